"""The reader's language: what is said to a person is translated where it is said, and only there.

Records, logs and every file that a machine reads stay English, whatever the language. The texts
are written in English all over the program; `translate` finds the template that a text was made
from in the catalogue (``<language>.po``) and says it again in the language chosen.
"""

from pipeline.language.translate import translate
from pipeline.reader_language import ENGLISH, LANGUAGES, VARIABLE, as_it_is, current, use, wanted

__all__ = ["ENGLISH", "LANGUAGES", "VARIABLE", "as_it_is", "current", "translate", "use", "wanted"]
