"""The script that compares a transcription with the paper's source, letter for letter."""

from __future__ import annotations

import json
import sys
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

from voronec.audit import Display, Paper, Section, Sentence, load_paper
from voronec.errors import DefinitionError

TOOLS = Path(__file__).resolve().parent.parent / "tools"

SOURCE = r"""\documentclass{article}
\newcommand{\nothing}{\begin{equation} not in the body \end{equation}}
\begin{document}
\section[Short]{The  first
  section}\label{one}
Here $a=b$ and \$5, a line\\[2pt] and $c$$d$.
% \begin{equation} commented out \end{equation}
\begin{equation}\label{e}
x = y, \qquad 100\%
\end{equation}
Text.\footnote{A note: \[ \frac{1}{2} \] in it.}
\subsection*{Second}
$$
u_{1} = v\\[3pt]
$$
\begin{eqnarray*} p &=& q \\ r &=& s \end{eqnarray*}
\section{Empty}
\end{document}
\[ after the end \]
"""
FIRST = (
    "\\begin{equation}\\label{e}\nx = y, \\qquad 100\\%\n\\end{equation}",
    r"\[ \frac{1}{2} \]",
)
SECOND = ("$$\nu_{1} = v\\\\[3pt]\n$$", r"\begin{eqnarray*} p &=& q \\ r &=& s \end{eqnarray*}")


@pytest.fixture(autouse=True, name="_tools")
def _tools(monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
    monkeypatch.syspath_prepend(str(TOOLS))
    yield
    for name in ("papers.transcription", "papers.latex_source"):
        sys.modules.pop(name, None)


def section(title: str, displays: tuple[str, ...], inline: tuple[str, ...] = ()) -> Section:
    return Section(
        title,
        tuple(map(Display, displays)),
        lambda _: {},
        inline=tuple(map(Display, inline)),
    )


def paper(
    first: tuple[str, ...] = FIRST,
    second: tuple[str, ...] = SECOND,
    inline: tuple[str, ...] = ("$a=b$", "$d$"),
) -> Paper:
    return Paper("p", "P", (section("The first section", first, inline), section("Second", second)))


def differences(made: Paper, source: str = SOURCE) -> list[Any]:
    from papers.latex_source import read_sections
    from papers.transcription import compare

    return list(compare(read_sections(source), made).differences)


def test_every_display_of_the_source_is_found_where_it_stands() -> None:
    from papers.latex_source import read_sections

    before, first, second, empty = read_sections(SOURCE)
    assert not before.displays
    assert (first.title, second.title, empty.title) == ("The first section", "Second", "Empty")
    assert tuple(d.latex for d in first.displays) == FIRST
    assert [d.latex for d in first.inline] == ["$a=b$", "$c$", "$d$"]
    assert tuple(d.latex for d in second.displays) == SECOND
    assert [d.line for d in (*first.displays, *second.displays)] == [8, 11, 13, 16]


@pytest.mark.parametrize("name", ["align*", "gather", "multline"])
def test_other_environments_count(name: str) -> None:
    from papers.latex_source import read_sections

    text = f"\\begin{{{name}}} a \\end{{{name}}}"
    (found,) = read_sections(f"\\begin{{document}}{text}\\end{{document}}")
    assert [d.latex for d in found.displays] == [text]


def test_what_is_equal_has_no_difference() -> None:
    assert differences(paper()) == []


def test_outer_white_space_is_no_difference() -> None:
    assert differences(paper(first=(f"  {FIRST[0]}\n", FIRST[1]))) == []


def test_a_missing_display_is_reported() -> None:
    (found,) = differences(paper(first=FIRST[1:]))
    assert (found.section, found.place) == ("The first section", "display 1, line 8")
    assert found.what == "is not transcribed"


def test_a_display_too_many_is_reported() -> None:
    (found,) = differences(paper(second=(*SECOND, "$$z$$")))
    assert found.place == "display 3 of the transcription"
    assert (found.what, found.transcribed) == ("is not in the source", "$$z$$")


def test_a_tidied_display_is_shown_with_the_place() -> None:
    tidied = SECOND[0].replace("u_{1}", "u_1")
    (found,) = differences(paper(second=(tidied, SECOND[1])))
    assert found.place == "display 1, line 14"
    assert "u_{1} = v" in found.source
    assert "u_1 = v" in found.transcribed


def test_white_space_inside_counts() -> None:
    assert differences(paper(first=(FIRST[0].replace("x = y", "x =  y"), FIRST[1])))


def test_a_swapped_order_is_reported() -> None:
    found = differences(paper(second=SECOND[::-1]))
    assert found
    assert all("is transcribed as display" in f.what for f in found)


def test_an_inline_formula_that_is_not_in_its_section_is_reported() -> None:
    (found,) = differences(paper(inline=("$a=b$", "$a = b$")))
    assert (found.place, found.transcribed) == ("inline formula 2", "$a = b$")


def test_a_quotation_that_is_not_in_its_section_is_reported() -> None:
    whole = paper()
    for text, count in (("a line\\\\[2pt]\n and", 0), ("Text. \\footnote", 1), ("Text, and", 1)):
        first = replace(whole.sections[0], sentences=(Sentence(text, unaudited="a trial"),))
        made = replace(whole, sections=(first, whole.sections[1]))
        found = [d for d in differences(made) if d.place == "quotation 1"]
        assert len(found) == count, text
    assert "differs from this section's text at its character 5" in found[0].what


def test_a_section_that_was_forgotten_is_reported() -> None:
    (found,) = differences(replace(paper(), sections=paper().sections[:1]))
    assert (found.section, found.what) == ("Second", "this section is not in the transcription")


def test_a_section_that_the_source_does_not_have_is_reported() -> None:
    made = replace(paper(), sections=(*paper().sections, section("Third", ())))
    assert [f.what for f in differences(made)] == ["the source has no section of this title"]


def test_sections_in_another_order_are_reported() -> None:
    made = replace(paper(), sections=paper().sections[::-1])
    assert [f.what for f in differences(made)] == ["the section is elsewhere"]


@pytest.mark.parametrize(
    ("text", "complaint"),
    [
        ("no document", "no \\begin{document}"),
        ("\\begin{document}\n\\[ a", "line 2: '\\[' has no '\\]'"),
        ("\\begin{document} $$ a $", "has no '$$'"),
    ],
)
def test_what_is_no_article_is_refused(text: str, complaint: str) -> None:
    from papers.latex_source import read_sections

    with pytest.raises(DefinitionError) as error:
        read_sections(text)
    assert complaint in str(error.value)


def printed(made: Paper) -> str:
    """A source that agrees with a transcription."""
    parts = ["\\begin{document}"]
    for part in made.sections:
        parts += [f"\\section{{{part.title}}}"]
        quotations = [sentence.quotation for sentence in part.sentences]
        for formula in (*part.inline, *part.displays):
            around = [text for text in quotations if formula.latex in text]
            parts += [text for text in around[:1] if text not in parts]
            parts += [] if around else [formula.latex]
        parts += [text for text in quotations if text not in parts]
    return "\n".join([*parts, "\\end{document}"])


def test_the_command_tells_equal_from_different(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    from papers.transcription import main

    file = tmp_path / "paper.tex"
    made = load_paper("demchenko")
    file.write_text(printed(made))
    assert main([str(file)]) == 0
    assert "NO" not in capsys.readouterr().out
    file.write_text(printed(made).replace("C_1=A_1+A_2", "C_1=A_1 + A_2"))
    assert main([str(file), "--json"]) == 1
    result = json.loads(capsys.readouterr().out)
    assert not result["equal"]
    assert [d["source"] for d in result["differences"]] != [""]
    assert sum(row["transcribed"] for row in result["rows"]) == 94


@pytest.mark.parametrize(
    "arguments", [["missing.tex"], ["missing.tex", "--paper", "nobody"], ["."]]
)
def test_bad_input_is_one_line_and_status_two(
    arguments: list[str], capsys: pytest.CaptureFixture[str]
) -> None:
    from papers.transcription import main

    assert main(arguments) == 2
    shown = capsys.readouterr()
    assert shown.out == ""
    assert len(shown.err.strip().splitlines()) == 1
