"""Words that tell a measured column from a set-point, a spread, an extreme or a calculation."""

SET_POINT = (
    *("set-point", "setpoint", "target", "demand", "limit", "задан*", "уставк*", "предел*"),
)
_SPREAD = (
    *("std", "stdev", "std-dev", "standard-deviation", "sd", "sigma", "σ", "variance"),
    *("error", "errors", "uncertainty", "deviation"),
    *("ско", "погрешност*", "ошибк*", "неопределенност*", "отклонен*", "дисперси*"),
)
_SIMULATED = ("cfd", "simulated", "simulation", "predicted", "prediction")
#: A column with such a word holds no measured value.
NOT_MEASURED = (*SET_POINT, *_SPREAD, *_SIMULATED)
#: A frequency with such a word is another than the shaft's: of the motor's field, which has the
#: pole pairs in it, of its controller, or of the recorder.
NOT_OF_SHAFT = (
    *("emf", "commutation", "pwm", "sampling"),
    *("эдс", "коммутаци*", "шим", "дискретизаци*", "опрос*"),
)
#: A column with such a word may be all there is: a torque is often calculated from a force.
CALCULATED = (
    *("calculated", "computed", "calc", "theoretical", "theory", "model"),
    *("расчет", "расчетн*", "рассчитан*", "вычислен*", "теоретическ*", "модел*"),
)
_EXTREMES = (
    *("min", "max", "minimum", "maximum", "peak", "lowest", "highest"),
    *("макс", "минимальн*", "максимальн*", "минимум", "максимум", "пик*"),
)
#: Columns with such a word are read where no other has the quantity.
SECOND_RANK = (*CALCULATED, *_EXTREMES)
#: Columns with such a word are what the bench measured.
FIRST_RANK = (
    *("measured", "mean", "avg", "average", "exp", "experiment*"),
    *("измерен*", "средн*", "эксперимент*", "опыт*"),
)
