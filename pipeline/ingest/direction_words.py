"""What a direction of thrust or of turning is called, in English, Russian and a few others."""

#: Words of a direction of thrust; a cell must hold one of them alone.
FORWARD = (
    *("forward", "forwards", "fwd", "ahead", "positive", "pos", "normal"),
    *("вперед", "передний", "передний ход", "пх", "прямой", "прямое", "положительное"),
    *("vorwärts", "voraus", "avant", "adelante"),
)
REVERSE = (
    *("reverse", "reversed", "rev", "astern", "backward", "backwards", "back", "bwd", "aft"),
    *("negative", "neg", "назад", "реверс", "задний", "задний ход", "зх", "обратный", "обратное"),
    *("отрицательное", "rückwärts", "zurück", "arrière", "atrás"),
)
#: Of a shaft: clockwise is taken for ahead, as the screw of most benches is right-handed.
CLOCKWISE = (
    *("cw", "clockwise", "right", "правое", "правый", "право", "по часовой", "по часовой стрелке"),
    "rechts",
)
COUNTERCLOCKWISE = (
    *("ccw", "counterclockwise", "counter clockwise", "anticlockwise", "anti clockwise", "left"),
    *("acw", "левое", "левый", "лево", "против часовой", "против часовой стрелки", "links"),
)
NAMES = (
    *("direction", "dir", "sense", "rotation", "turn", "direction of rotation", "thrust direction"),
    *("направление", "вращение", "направление вращения", "ход", "реверс", "richtung", "sens"),
)
