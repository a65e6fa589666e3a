"""What the columns and headings of a mooring test are called, in English and Russian."""

import re

from pipeline.ingest.word_lists import vocabulary_of, words_of

VOCABULARY = vocabulary_of("mooring")
UP = words_of("directions", "up")
DOWN = words_of("directions", "down")
#: What is done to a rig, and says nothing of the order of codes.
OF_THE_RIG = re.compile(
    r"\b(set|warm\w*|power\w*|start\w*|back|close|mock|wake) up\b"
    r"|\b(cool\w*|power\w*|shut|break|tear|strip|wind) down\b"
)
#: A lever between thruster and sensor, or a factor: whether the numbers hold it people must say.
LEVER = re.compile(
    r"\b(?:lever\w*|moment arm|arm ratio|arms?\b(?=.*\d)|pivot\w*|rocker|bell[ -]?crank|beam ratio"
    r"|рычаг\w*|плеч[оеа]\w*|коромысл\w*|балансир\w*|качалк\w*)\b"
    r"|\b(?:multipl\w*|divid\w*|умнож\w*|раздел[иеё]\w*|дел[ие]\w*|множител\w*)\b.{0,30}?\d",
    re.IGNORECASE,
)
