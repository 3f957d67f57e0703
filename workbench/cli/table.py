"""workbench table: a study's tables again, or columns of its results."""

from typing import Annotated

import typer

from workbench.cli.options import Folder, Where, conditions, print_tables, say
from workbench.errors import UserError


def command(
    folder: Folder,
    column: Annotated[
        list[str] | None, typer.Option(help="Show this column of the results instead. May be repeated.")
    ] = None,
    where: Where = None,
) -> None:
    """Write a study's tables again, or show columns of its results."""
    from workbench.study.reading import read_study
    from workbench.study.report.folder import write_answers, write_tables
    from workbench.study.report.select import columns_of
    from workbench.study.store import STUDY_COPY, read_results

    frame = read_results(folder)
    if column or where:
        say(columns_of(frame, column or [], conditions(where)).to_markdown(index=False, floatfmt=".6g"))
        return
    study = read_study(folder / STUDY_COPY)
    tables, pages = write_tables(study, frame, folder), write_answers(study, frame, folder)
    if not tables and not pages:
        raise UserError(f"{folder}: its study asks for no tables; choose columns with --column")
    print_tables(tables)
    for page in pages:
        say(f"wrote {page}")
