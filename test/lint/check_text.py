# SPDX-License-Identifier: Apache-2.0
"""Check the texts of the project: forbidden words and phrases, licence lines, lengths of files, functions and lines, form of
contracts, banners and comments, and the dialect of C."""

import ast
import os
import pathlib
import re
import sys

ROOT = pathlib.Path(__file__).resolve().parents[2]
SKIPPED = {".git", "build", "runs", "__pycache__", ".pytest_cache"}
FILE_LINES, FUNCTION_LINES, CONTRACT_LINES, COMMENT_COLUMNS = 600, 60, 15, 110
MAKEFILE_COLUMNS = 120
README_LINES = 60  # Maximum of README.md in the top directory, so that a reader sees all of it at once.


def project_files():
    for directory, directories, names in os.walk(ROOT):
        directories[:] = sorted(set(directories) - SKIPPED)
        for name in sorted(names):
            yield pathlib.Path(directory, name)


def c_functions(lines):
    """(line of the name, length) of each function; clang-format puts both braces into the first column."""
    start = 0
    for number, line in enumerate(lines, 1):
        if line == "{":
            start = number
        elif line == "}" and start:
            yield start, number - start + 1
            start = 0


def python_functions(text):
    for node in ast.walk(ast.parse(text)):
        if isinstance(node, (ast.FunctionDef, ast.AsyncFunctionDef)):
            yield node.lineno, node.end_lineno - node.lineno + 1


def length_breaches(path, text):
    lines = text.splitlines()
    if len(lines) > FILE_LINES:
        yield f"{path}:1: {len(lines)} lines, {FILE_LINES} allowed"
    functions = python_functions(text) if path.suffix == ".py" else c_functions(lines)
    for number, length in functions:
        if length > FUNCTION_LINES:
            yield f"{path}:{number}: function of {length} lines, {FUNCTION_LINES} allowed"


LABEL = r"(Ownership|Context|Time|Errors|Order|Units|Results|Names|Bounds|Frame)"
MID_LABEL = re.compile(r"^\s*///.*[^\s/].*[.;,)] +" + LABEL + r"(:| {2,}| (?=O\())")
LABEL_LINE = re.compile(r"^/// " + LABEL + r"(:| {2,})")


def contract_breaches(path, lines):
    """Labels of a contract must be at the beginning of a line with their text indented; a header's contract
    must be short."""
    is_labelled = False
    for number, line in enumerate(lines, 1):
        label = MID_LABEL.search(line)
        if label:
            yield f"{path}:{number}: label '{label[1]}' in the middle of a line"
        is_text = re.match(r"/// \S", line) is not None
        if LABEL_LINE.match(line):
            is_labelled = True
        elif is_labelled and is_text and not re.match(r"/// [A-Z][a-z]+ {2,}\S", line):
            yield f"{path}:{number}: the text of a label is not indented"
        is_labelled = is_labelled and line.startswith("/// ")
    if path.suffix == ".h":
        length = next((number for number, line in enumerate(lines[1:]) if not line.startswith("///")), 0)
        if length > CONTRACT_LINES:
            yield f"{path}:2: contract of {length} lines, {CONTRACT_LINES} allowed: move details to docs/"


BANNER = re.compile(r"// ---- [A-Z][^-]*(-[^-]+)* ----$")
COMMENT = re.compile(r"(?:^|\s)///?<? (.*)$")
HASHED = re.compile(r"(?:^|\s)# (.*)$")
SENTENCES = {".c": COMMENT, ".h": COMMENT, ".inc": COMMENT, ".js": COMMENT, ".py": HASHED, ".sh": HASHED, ".mk": HASHED, ".md": re.compile(r"(.+)")}
LITERAL = re.compile(r'"((?:[^"\\]|\\.)*)"')


DOUBLED_MARK = re.compile(r"^\s*(?:///? ///?|# #) ")


def comment_breaches(path, lines):
    """Comments beyond the column limit, and banners (comments that head a section) in another form than `// ---- Text ----`, for example a
    comment of one line between blank lines."""
    for number, (before, line, after) in enumerate(zip(["-", *lines], lines, [*lines[1:], "-"]), 1):
        if (line.startswith("// --") or (line.startswith("// ") and before == after == "")) and not BANNER.match(line):
            yield f"{path}:{number}: a banner is written `// ---- Text ----`"
        comment = COMMENT.search(line)
        if comment and len(line) > COMMENT_COLUMNS and "NOLINT" not in line:
            yield f"{path}:{number}: comment beyond column {COMMENT_COLUMNS}"


PREFIXED_TEST = re.compile(r"^(?:static )?void (test_\w+)\(void(?: ?\*|\))")
SIZE_OF = re.compile(r'\bsizeof ?\((?!\w+_t\)|(?:bool|char|double|float|int|long|short|unsigned)\))'
                     r'(\*?[a-z_]+[a-z_0-9]*(?:(?:\.|->)\w+|\[[^]]*\])*|"(?:[^"\\]|\\.)*")\)(?!\.|->|\[)')


def dialect_breaches(path, lines):
    """C tests with the prefix test_, and sizeof with parentheses around an expression outside of macros."""
    for number, (before, line) in enumerate(zip(["", *lines], lines), 1):
        name, size = PREFIXED_TEST.match(line), SIZE_OF.search(line)
        if name:
            yield f"{path}:{number}: {name[1]}: name a test by the condition and the result, without test_"
        if size and not (line.startswith("#define") or before.endswith("\\")):
            yield f"{path}:{number}: write `sizeof {size[1]}`: only types have parentheses"


def sentences(path, text):
    """(line number, text) of everything that is written for readers: comments, docstrings, pages, and texts
    of the programs."""
    lines = text.splitlines()
    if path.suffix == ".py":
        for node in ast.walk(ast.parse(text)):
            if isinstance(node, ast.Expr) and isinstance(node.value, ast.Constant) and isinstance(node.value.value, str):
                yield from ((number, lines[number - 1]) for number in range(node.lineno, node.end_lineno + 1))
    pattern = SENTENCES.get(path.suffix)
    if path.suffix == ".c" and path.parts[0] != "test":
        yield from ((number, found) for number, line in enumerate(lines, 1) for found in LITERAL.findall(line))
    if pattern:
        yield from ((number, found[1]) for number, line in enumerate(lines, 1) if (found := pattern.search(line)))


def breaches(path, words, phrases):
    try:
        text = (ROOT / path).read_text()
    except UnicodeDecodeError:
        return
    for number, line in enumerate(text.splitlines(), 1):
        found = words.search(line)
        if found:
            yield f"{path}:{number}: '{found[0]}' does not belong here"
        if (path.name == "Makefile" or path.suffix == ".mk") and len(line) > MAKEFILE_COLUMNS:
            yield f"{path}:{number}: {len(line)} columns, {MAKEFILE_COLUMNS} allowed"
        if path.suffix in SENTENCES and path.suffix != ".md" and DOUBLED_MARK.match(line):
            yield f"{path}:{number}: a comment begins with one mark"
        if path.suffix in {".js", ".css"} and len(line) > COMMENT_COLUMNS:
            yield f"{path}:{number}: {len(line)} columns, {COMMENT_COLUMNS} allowed"
    if path == pathlib.Path("README.md") and text.count("\n") > README_LINES:
        yield f"{path}:1: {text.count(chr(10))} lines, {README_LINES} allowed: move details to docs/"
    for number, sentence in sentences(path, text):
        found = phrases.search(sentence)
        if found:
            yield f"{path}:{number}: '{found[0]}' in a text: say who acts, and what is done"
    if path.suffix in {".c", ".h", ".js", ".py"}:
        yield from length_breaches(path, text)
    if path.suffix in {".c", ".h"}:
        yield from contract_breaches(path, text.splitlines())
        yield from comment_breaches(path, text.splitlines())
        yield from dialect_breaches(path, text.splitlines())
    if path.suffix in {".c", ".h", ".py", ".sh"} and "SPDX-License-Identifier: Apache-2.0" not in text[:200]:
        yield f"{path}:1: no licence line"


def read_words():
    """Two patterns from words.txt: of words that no line may contain, and of phrases that no text for readers (`sentences`) may
    contain. A rule for texts begins with the word "comment"."""
    rules = [rule for rule in (ROOT / "test/lint/words.txt").read_text().splitlines() if rule and not rule.startswith("#")]
    phrases = [rule.removeprefix("comment ") for rule in rules if rule.startswith("comment ")]
    words = [rule for rule in rules if not rule.startswith("comment ")]
    return re.compile("|".join(words), re.IGNORECASE), re.compile("|".join(phrases))


def main():
    words, phrases = read_words()
    files = [path.relative_to(ROOT) for path in project_files() if path.name != "LICENSE"]
    failures = [text for path in files for text in breaches(path, words, phrases)]
    print("\n".join(failures) if failures else f"check: words and lengths are right in {len(files)} files")
    return 1 if failures else 0


if __name__ == "__main__":
    sys.exit(main())
