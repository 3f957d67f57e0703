"""The bench: a loop in a browser, its parameters as sliders, and scopes that follow the hand.

What is on the bench is a study of one case (`loop`), what can be turned there are keys of it (`knobs`), what is seen
are its run and metrics (`outcome`, `scopes`): so what was found by hand is saved as a study file that gives the same
numbers.
"""
