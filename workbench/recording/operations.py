"""What an equation may compute, by the name of NumPy's function."""

ORDERING = ("less", "less_equal", "greater", "greater_equal", "equal", "not_equal")

LOGICAL = ("logical_and", "logical_or", "logical_not")

CONDITIONS = frozenset((*ORDERING, *LOGICAL))
"""Operations whose result is a condition."""

OF_CONDITIONS = frozenset((*LOGICAL, "where"))
"""Operations that take conditions; of others they are numbers, 1 or 0."""

OPERATIONS = CONDITIONS | {
    *("add", "subtract", "multiply", "divide", "negative", "absolute", "where", "minimum", "maximum", "sign"),
    *("power", "arctan2", "hypot", "copysign", "arcsin", "arccos", "arctan"),
    *("sqrt", "exp", "expm1", "log", "log1p", "log10", "sin", "cos", "tan", "sinh", "cosh", "tanh"),
    *("floor", "ceil", "rint", "trunc"),
}

SAME = {
    "bitwise_and": "logical_and",
    "bitwise_or": "logical_or",
    "invert": "logical_not",
    "fabs": "absolute",
    "true_divide": "divide",
}
"""Functions that do the same as another one here."""

NOT_THERE = "which is not among the functions of equations"
