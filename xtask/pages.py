#!/usr/bin/env python3
"""Looks at the pages of this repository: whether each link leads somewhere, and whether the commands of tutorials run.

  pages.py links           exit 1 if a link, an anchor or a picture of a page leads nowhere, or a page of docs/ is not in its SUMMARY.md
  pages.py run COHOLD      exit 1 if a block of commands after a line `<!-- run -->` fails; the blocks of a page run in order in one folder

The folder has everything of the repository's root but `target`, as links, so that commands find scenes and examples and write nothing there.
Needs Python 3.9 and git.
"""
import os
import re
import signal
import subprocess
import sys
import tempfile
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
LINK = re.compile(r"!?\[(?:[^\[\]]|\[[^\]]*\])*\]\(([^)\s]+)\)|<img src=\"([^\"]+)\"")
# Parts of pages, read where a program puts them.
PARTS = "firmware/wiring/"
# Pages of the site that no reader needs in its list.
UNLISTED = ("SUMMARY.md", "project/notes/")


# Longest that one block may take on a busy machine, s.
LONGEST_S = 120


def pages():
    listed = subprocess.run(["git", "ls-files", "--cached", "--others", "--exclude-standard", "*.md"], cwd=ROOT, capture_output=True, text=True, check=True)
    return [ROOT / name for name in listed.stdout.split("\n") if (ROOT / name).is_file() and not name.startswith(PARTS)]


def lines(page):
    """Lines outside code blocks, with their numbers."""
    fence = None
    for number, line in enumerate(page.read_text(encoding="utf-8").splitlines(), 1):
        opened = re.match(r"\s*(```+|~~~+)", line)
        if fence is None and opened:
            fence = opened.group(1)
        elif fence and line.strip().startswith(fence):
            fence = None
        elif fence is None and not re.match(r" {4}", line):
            yield number, line


def anchors(page):
    """The anchors of its headings, as a forge and mdBook make them."""
    found, seen = set(), {}
    for _, line in lines(page):
        found.update(re.findall(r"<a (?:id|name)=\"([^\"]+)\"", line))
        heading = re.match(r"#{1,6}\s+(.*)", line)
        if not heading:
            continue
        text = re.sub(r"\[([^\]]*)\]\([^)]*\)", r"\1", heading.group(1)).replace("`", "").replace("*", "").strip().lower()
        anchor = re.sub(r"[^\w\- ]", "", text).replace(" ", "-")
        count = seen.get(anchor, 0)
        seen[anchor] = count + 1
        found.add(f"{anchor}-{count}" if count else anchor)
    return found


def links():
    wrong, known = [], {}
    for page in pages():
        name = page.relative_to(ROOT)
        for number, line in lines(page):
            for found in LINK.finditer(re.sub(r"`[^`]*`", "", line)):
                target = found.group(1) or found.group(2)
                if re.match(r"[a-z]+:", target):
                    continue
                path, _, anchor = target.partition("#")
                to = (page.parent / path).resolve() if path else page
                if not to.exists():
                    wrong.append(f"{name}:{number}: {target} is not there")
                elif anchor and to.suffix == ".md" and anchor not in known.setdefault(to, anchors(to)):
                    wrong.append(f"{name}:{number}: {target} has no such heading")
    docs = ROOT / "docs"
    summary = docs / "SUMMARY.md"
    if summary.exists():
        listed = {(docs / found.group(1)).resolve() for found in LINK.finditer(summary.read_text(encoding="utf-8")) if found.group(1)}
        for page in pages():
            inside = page.relative_to(ROOT).as_posix()
            if inside.startswith("docs/") and page not in listed and not inside[len("docs/"):].startswith(UNLISTED):
                wrong.append(f"{inside} is not in docs/SUMMARY.md")
    return wrong


def blocks(page):
    """The blocks of commands that are to run, with the number of their first line."""
    text = page.read_text(encoding="utf-8").splitlines()
    for at, line in enumerate(text):
        if line.strip() == "<!-- run -->":
            if at + 1 >= len(text) or not text[at + 1].startswith("```sh"):
                sys.exit(f"{page.relative_to(ROOT)}:{at + 1}: `<!-- run -->` is not followed by a block of sh")
            end = text.index("```", at + 2)
            yield at + 3, "\n".join(text[at + 2:end])


def done(block, folder, place):
    """Exit status and words of a block of commands. What it leaves running in the background ends with it."""
    with tempfile.TemporaryFile("w+") as said:
        shell = subprocess.Popen(["bash", "-e", "-c", block], cwd=folder, env=place, stdout=said, stderr=said, stdin=subprocess.DEVNULL, start_new_session=True)
        try:
            status = shell.wait(LONGEST_S)
        except subprocess.TimeoutExpired:
            status = f"none after {LONGEST_S} s"
        try:
            os.killpg(shell.pid, signal.SIGTERM)
        except ProcessLookupError:
            pass
        said.seek(0)
        return status, said.read()


def run(program):
    program, wrong = Path(program).resolve(), []
    place = {**os.environ, "PATH": f"{program.parent}{os.pathsep}{os.environ['PATH']}"}
    for page in pages():
        commands = list(blocks(page))
        if not commands:
            continue
        with tempfile.TemporaryDirectory() as folder:
            for entry in ROOT.iterdir():
                if entry.name not in ("target", "out", ".git"):
                    (Path(folder) / entry.name).symlink_to(entry)
            for number, block in commands:
                name = f"{page.relative_to(ROOT)}:{number}"
                print(f"    {name}")
                status, said = done(block, folder, place)
                # 1: it is done, and the result is a bad one, which the page says.
                if status not in (0, 1):
                    wrong.append(f"{name}: exit status {status}\n{said[-4000:]}")
                    break
    return wrong


def main():
    given = sys.argv[1:]
    if given == ["links"]:
        wrong = links()
    elif len(given) == 2 and given[0] == "run":
        wrong = run(given[1])
    else:
        sys.exit(__doc__)
    print("\n".join(wrong), file=sys.stderr, end="\n" if wrong else "")
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())
