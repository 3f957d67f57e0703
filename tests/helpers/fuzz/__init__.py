"""Mutated files: whatever a file holds, a command works or refuses it in at most three lines.

    make fuzz                                                        # ten minutes, of all three kinds
    PYTHONPATH=tests/helpers python -m fuzz check --count 100000     # studies and what they name, checked
    PYTHONPATH=tests/helpers python -m fuzz run --seconds 60         # small studies, run
    PYTHONPATH=tests/helpers python -m fuzz records --seed 7 --only 1234    # one mutant again, with what it holds

A mutant is told by the seed and its number alone. What is found: a traceback, a process that ends, more than ten
seconds, a file outside the folder of results, a refusal of more than three lines or a long one, a warning that is not
the program's.
"""
