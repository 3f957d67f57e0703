"""The code blocks of README.md and docs/: what each is, and running them in order, page by page.

    make docs-test                # every block that is run, each page in a folder of its own
    make docs-test PAGE=tuning    # those of one page

A comment right above a block says what it is:

    <!-- file: NAME -->           written as NAME into the page's folder; TOML is checked
    <!-- part of: NAME, ... -->   a fragment, laid over the file NAME of this page, or of the repository, and checked
    <!-- quick -->                run by the tests too, in seconds
    <!-- output -->               lines that the block before prints
    <!-- illustration: REASON --> not run, and why

Without one a block of sh or python is run by `make docs-test`, and one of toml is checked as a file of its own. Of
commands in any block of sh the names and options are checked, whether it is run or not.
"""
