#!/usr/bin/env python3
"""Measures prose: Markdown pages, Rust doc comments, and the strings that a program shows (help, errors).

  prose.py README.md docs CHANGELOG.md            a row for each page
  prose.py core host-sim --kind rust              a row for each file of doc comments
  prose.py host-sim --kind strings                strings of four words or more outside tests
  prose.py README.md docs --worst 20              the worst sentences, with file:line
  prose.py --compare ours=. rust=../book     a row for each set of Markdown pages
  prose.py README.md docs --max-mean 22 --max-p90 32 --max-private 0    exit 1 if a page is beyond a bound
  prose.py --words                                the word list as a Markdown table
  prose.py --check [--bless]                      exit 1 if a file of this repository is beyond its ceilings; --bless lowers them

Counted are sentences of running text and of list items. Code blocks, tables, headings, front matter and generated blocks
(after `<!-- table of cohold … -->`) are left out, except that private words are looked for in table cells and headings too.
An inline code span counts as one word. Needs Python 3.9 and nothing else.
"""
import argparse
import json
import re
import subprocess
import sys
from pathlib import Path

# Pattern (or "" where only a reader can tell) | private word | write instead | what the field calls it, or why.
WORDS = r"""
\bit stands as\b|\bstands? (?:in|at|under|above|below|beside|there|here|still|behind|between|on)\b|stands (in, at, under)|is; is listed in; is printed below|nothing "stands" in a table or a file
\b(?:end|line|peer|copy|robot|it|point|wall|that) stands\b|\bticks? (?:that|in which .{0,20}) stands?\b|\bstood\b|\bstanding (?:end|line|tick)|stands (an end, a line)|is paused; has no sample; holds its last value|buffer underrun, hold-last-sample
(?<!there )\bis no (?!longer|more|less|way|need|such|reason|one|difference|guarantee|point|doubt|problem|default|limit|data\b)\w+|is no (key file)|is not a (key file)|English negates the verb
\bthere are none within\b|there are none within it|no tuning met the limit|
\bletting? go(?:es)?\b(?! of the (?:device|handle|button|mouse))|\blets? go\b|\blet go\b|let go (a peer, a device)|disengage; release; stop applying force|"release" for a hand, "disengage" for a peer
\btold\b|told (a value, an address)|reported; sent; given; configured|
|tells|reports; sends; explains|
\bheard\b|\bhears\b|heard (a peer, a packet)|received|receive a packet
\b(?:fresh|old|newest|late[rs]t?|of|over|the) news\b|news|data; the latest packet; received state|age of information
\bmade energy\b|\bmakes? (?:no )?energy\b|\benergy made\b|(?:channel|peer) made\b|made energy, peer made|generated energy|"energy generation": violation of passivity
\bgave out\b|\bgives? out\b|gives out (energy)|delivers; dissipates|
\bpaid for\b|\bpays for\b|\bpay to\b|pays for (energy)|is covered by; is funded from the tank|energy budget
\bflies\b|\bflown\b|the code that flies|the firmware's own code|
\blie beside\b|\bbeside\b|beside|next to; compared with; in addition to|
\bfar hand\b|far hand|remote user|remote (other) side
\bnear(?:est|er)? (?:the|it|they) (?:holds?|keep|copies)|holds the copies near|position error between the copies|position tracking, coherency
\bcopies (?:come |came |are |were |stay |be )?(?:\d+ mm )?apart\b|\bcopies .{0,20}tear apart\b|copies apart|copies apart|the copies differ by … mm|position discrepancy, position error|
\bis \*?\*?apart\*?\*?\b|apart (verdict)|diverged: position error over the limit|use one verdict word per meaning
\bgoes (?:by|on (?!to\b)|at|round|with|over|anew)\b|goes by, goes on|uses; continues; changes to|
\bgoing on as\b|\bcarr(?:y|ies|ying) on\b|carry on|extrapolate; coast|dead reckoning, extrapolation
\bcarried (?:on|along)\b|carried on|extrapolated|
\bthe way (?:there|back|of)\b|\bway there and back\b|there and back, the way of|round trip; distance moved|round-trip time (RTT)
\bthere and back\b|there and back|round trip|RTT
\bflow(?:s|ed)? (?:goes|changes|by|over)\b|\bFlow goes\b|flow|traffic; packets|
\bjoins? the cable\b|\bcable (?:is|was) (?:cut|joined)\b|the cable is cut, joins|the network is disconnected, reconnected|"link down"
\bis begun\b|\bbegins? anew\b|\banew\b|begins anew|restarts|
\bof one's own\b|\bof (?:its|their) own\b|of its own|separate; independent; dedicated|
\bwho(?:ever)? (?:has|holds|takes|scans|listens|comes|gives|is) \w+ (?:has|holds|takes|reads|can|may)\b|who has X may Y|anyone with X can Y|
\bwhat is (?:constant|left|whole|sent|lost|told|heard|felt|cut|kept|new)\b|what is lost, what is left|lost packets; the remainder|name the thing
\bby what (?:is|was|it|they|a)\b|\bof what (?:is|was|it|they|a)\b|\bthan what (?:is|was)\b|of what, for what|name the thing|headless clause
\bwhere it (?:is|was|has) (?:not )?\w+ed\b|where it is held|if the axis is engaged|"where" is for places; conditions take "if" or "when"
|so that (more than once a page)|so; to …|split the sentence
\bthat of\b|\bthose of\b|that of, those of|repeat the noun|pronouns that point two nouns back cost a second reading
\bthe one .{2,40} the other\b|the one … the other|peer 1 … peer 2|
\bat the most\b|\bat most\b.{0,12}\bat (?:the )?least\b|at the most|at most; up to|
\bthe least\b|\bleast of\b|the least (delay)|minimum|minimum
\bthe most\b(?= (?:that|of|a|it))|the most (that …)|maximum|maximum
\bquickest\b|quickest|fastest; minimum-delay|
\bless the\b|less the (least)|minus; after subtracting|
\bas ever\b|\bas it (?:went|was|stood)\b|as it went|unchanged; at its last velocity|
\bmends\b|mends (a page)|updates; fixes|
\bbears?\b (?:every|no|any|it|the|all|what)|bears (a network)|tolerates; is robust to|robustness
\bsits?\b in\b|sits in|is in|
\bbegins with\b (?:what|an energy)|begins with an energy|starts with a stored energy of|initial tank energy
\blooked for\b|looked for|searched|
\bforeign\b|foreign (text, packet)|untrusted; external|
\bdoor\b|door (to the network)|HTTP listener on the local network|
|nobody (pushes)|no user; no one|
\bovertaken\b|overtaken (packets)|reordered|reordering
\bplayed out\b(?! buffer)|played out|displayed after a 60 ms buffer|jitter (play-out) buffer
\bis a wall\b|\blike a wall\b|is a wall|holds rigidly at its last position|
\bline(?: between .{0,20})? (?:may )?weighs?\b|weighs (a line)|adds an apparent mass of|apparent mass
\bheav(?:y|ier)\b the line|heavy (line)|large apparent mass|
\bsealed\b|sealed|authenticated and encrypted|define once if kept (AEAD)
\bmeeting place\b|meeting place|rendezvous server|rendezvous, relay (TURN)
\bblind relay\b|blind relay|relay that cannot read the traffic|
\bnews that\b|news that is 8 ms old|data that is 8 ms old|
\bsay(?:s|ing)? (?:nothing|so|what|how|which|that it|which law)\b|says what|reports; lists; explains|
\bis said\b|\bwas said\b|\bare said\b|what is said|is reported|
\btogether with what\b|together with what|with …|
\bhas to\b (?:pay|be paid)|has to pay|must be covered by|
\bthrows?\b forged|throws forged datagrams|sends|
\bkept (?:nearest|near|by)\b|kept near|kept within N mm|
\bnumbers that must come out\b|\bcomes? out (?:at|as|with)\b|comes out|the expected result is|
\bat the bench\b|\bon the bench\b|on the bench|in the lab; connected to a PC|
\bwithout end\b|\bwithout an end\b|\bfor ever\b|without an end, for ever|unbounded; indefinitely|
\btried (?:on|at|for|by|in|with|over|of)\b|tried (on emulators)|tested|report tests, not tries
\bcome(?:s)? together (?:again)?\b|come together again|converge; reconnect|
\bgot rid\b|\bgrows on\b|grows on|diverges|instability
\bin silence\b|\bkeeps? silent\b|silent, silence|sends nothing; no packets received|time-out
\bstroke(?:s)?\b|strokes|hyphens|
\bblanks\b|blanks|spaces|
|held (a value)|kept constant until the next packet|zero-order hold
|held (a device, an object)|gripped; grasped; in contact|
|way (a column)|distance moved|displacement
|one way (adverb)|from peer 1 to peer 2|"one-way delay" is the field's term and stays
|seen (by a law)|observed; measured|observation
|goes (a point, a line)|moves; runs; advances|
|carried (by a packet)|contained in; in flight|payload
|there is nothing of|no data from|
|comes (a packet)|arrives|
|gone over to|switched to|
|found (a sentence's verb of result)|the test showed; we measured|
|whose is|owner|
|begins from rest|starts at zero velocity|
\bimpatience\b|impatience|underrun rate|
\bits tank is (?:not )?empty\b|\btank is short\b|when it is short|when the energy tank is depleted|energy tank
\bshare of\b|share of (ticks)|percentage of|
\bbought devices\b|bought devices|commercial devices|
\ba device of (?:your|one's) own\b|a device of your own|your own device; a custom device|
\bthree laws tear\b|\btear(?:s)? apart\b|tear apart|diverge|
\bcome(?:s)? to rest\b|comes to rest|settles|settling
\bas good\b|as good (points)|statistically indistinguishable|
\bby itself\b|\bof itself\b|by itself|automatically; independently|
\bone a tick\b|\ba packet a tick\b|\ba row a run\b|\brow a run\b|a row a run, one a tick|one row per run; once per tick|"per" for rates
\bwhat (?:it|they) (?:is|are) (?:made|worth|paid)\b|what it is worth|its value; its cost|
\bprice\b|\bprices\b|price (of a choice)|cost|computational cost
\btakes? back\b|takes back (permission)|revokes|
|what a hand feels|felt impedance; drag|transparency, displayed impedance
\blacks\b|lacks (N·s/m)|damping shortfall|passivity shortfall
\bport\b(?= (?:energy|least))|port energy least balance|minimum energy balance at the port|
\bsee[ns]?\b from both sides|seen from both sides|bracketed|root bracketing
"""


def rows():
    """(pattern or None, word, instead, why) of each line of WORDS."""
    for line in WORDS.strip().splitlines():
        # The pattern may have bars inside; the last three fields never have.
        pattern, word, instead, why = line.rsplit("|", 3)
        if word != "n/a":
            yield pattern.rstrip("|"), word.strip(), instead.strip(), why.strip()


PRIVATE = [(re.compile(pattern, re.I), word, instead) for pattern, word, instead, _ in rows() if pattern]
ABBREVIATION = re.compile(r"\b(e\.g|i\.e|vs|cf|Fig|fig|eq|Eq|No|no|al|Sec|approx|etc|Dr|St|resp|incl)\.$")
HEADLESS = re.compile(r"^(?:And |But |Of |So )?(?:What|Who|Whoever|Whatever|Whichever|Which|Where it|One that|One who|Those who|That which)\b")
HEADLESS_INSIDE = re.compile(r"\b(?:and|or|of|than|by|for|from|with|at|is|are) (?:what|whatever|whoever|who)\b", re.I)
PASSIVE = re.compile(r"\b(?:is|are|was|were|be|been|being)\s+(?:\w+ly\s+|not\s+|then\s+|also\s+)?(?:\w{2,}ed|made|held|given|taken|shown|sent|told|heard|kept|put|read|written|drawn|found|known|lost|cut|felt|seen|left|set|built|driven|meant|paid)\b", re.I)
# What a user has no use for: test names, files of tests or sources, hashes, load figures.
INNER = re.compile(r"`cargo test[^`]*`|`[^`]*\b(?:tests?|src)/[^`]*`|\((?:[^()]*/)?(?:tests|src)/[^)]*\)|`[0-9a-f]{7,40}`|\(tests?\)|\bload (?:of )?\d|`[a-z_]+::[a-z_:]+`|\b\w+\.rs\b")
SPOKEN = re.compile(r"\b[Ff]or (?:example|instance)\b|\be\.g\.|\bExamples?\b|\bsuch as\b")
YOU = re.compile(r"\b[Yy]ou(?:rs?)?\b")
EXAMPLE = re.compile(r"^(?:```|~~~|    \S|\t\S)|\b[Ff]or (?:example|instance)\b|\be\.g\.|\bExample\b", re.M)
WORD = re.compile(r"[^\s]*[A-Za-z0-9µΩθρ]+[^\s]*")


class Block:
    def __init__(self, line, text, prose=True):
        self.line, self.text, self.prose = line, text, prose


def markdown(lines):
    """Blocks of running text with the number of their first line; tables and headings come with prose=False."""
    blocks, now, fence, generated = [], None, None, False
    previous_blank, in_list = True, False

    def close():
        nonlocal now
        if now and now.text.strip():
            blocks.append(now)
        now = None

    numbered = list(lines)
    skip = 0
    if numbered and numbered[0][1].strip() == "---":       # front matter
        for at, (_, text) in enumerate(numbered[1:], 1):
            if text.strip() == "---":
                skip = at + 1
                break
    comment = False
    for number, text in numbered[skip:]:
        bare = text.strip()
        if comment:
            comment = "-->" not in bare
            continue
        if fence:
            if bare.startswith(fence):
                fence = None
            continue
        opened = re.match(r"(```+|~~~+)", bare)
        if opened:
            close()
            fence = opened.group(1)
            continue
        if bare.startswith("<!--"):
            close()
            comment = "-->" not in bare
            generated = bare.startswith("<!-- table of")
            continue
        if not bare:
            close()
            previous_blank = True
            continue
        if re.match(r"( {4}|\t)", text) and previous_blank and not in_list:
            continue
        if bare.startswith("|") or re.match(r"^[-|: ]+$", bare):
            close()
            if not generated and re.search(r"[A-Za-z]{3}", bare):
                blocks.append(Block(number, bare, prose=False))
            previous_blank = False
            continue
        generated = False
        if bare.startswith("#") and not bare.startswith("#["):
            close()
            blocks.append(Block(number, bare.lstrip("# "), prose=False))
            in_list = False
        elif re.match(r"([-*+]|\d+[.)])\s", bare):
            close()
            in_list = True
            now = Block(number, re.sub(r"^([-*+]|\d+[.)])\s+", "", bare))
        elif re.match(r"^(<[a-zA-Z/!]|!\[|\{\{|:::|\[[^\]]+\]:)", bare):
            close()
        else:
            if previous_blank and not text.startswith(" "):
                in_list = False
            bare = bare.lstrip("> ")
            if now is None:
                now = Block(number, bare)
            else:
                now.text += " " + bare
        previous_blank = False
    close()
    return blocks


def rust_docs(text):
    """Doc comments as Markdown, each run of them by itself."""
    blocks, run = [], []
    for number, line in enumerate(text.splitlines(), 1):
        found = re.match(r"\s*//[/!](?!/) ?(.*)", line)
        if found:
            run.append((number, found.group(1)))
        elif run:
            blocks += markdown(run)
            run = []
    return blocks + markdown(run)


STRING = re.compile(r'"((?:[^"\\]|\\.)*)"', re.S)


def strings(text):
    """String literals of four words or more before `mod tests`, which a user may come to read."""
    text = re.split(r"#\[cfg\(test\)\]\s*mod ", text)[0]
    text = re.sub(r"^\s*//.*$", "", text, flags=re.M)
    blocks = []
    for found in STRING.finditer(text):
        said = re.sub(r"\\\s*\n\s*", "", found.group(1)).replace("\\n", " ")
        said = re.sub(r"\{[^}]*\}", "X", said)
        if len(re.findall(r"[a-z]{2,}", said)) >= 4 and " " in said.strip():
            blocks.append(Block(text.count("\n", 0, found.start()) + 1, said))
    return blocks


def plain(text):
    text = re.sub(r"`[^`]+`", "CODE", text)
    text = re.sub(r"!\[[^\]]*\]\([^)]*\)", " ", text)
    text = re.sub(r"\[([^\]]*)\]\([^)]*\)", r"\1", text)
    text = re.sub(r"\[([^\]]*)\]\[[^\]]*\]", r"\1", text)
    text = re.sub(r"<[^>]{1,200}>", " ", text)
    text = re.sub(r"\{\{.*?\}\}", " ", text)
    return text.replace("**", "").replace("__", "")


def sentences(text):
    """Text cut at full stops before a capital; abbreviations do not end a sentence."""
    out, begin = [], 0
    for found in re.finditer(r"[.!?][)\"'”*]*\s+(?=[\"'“(*]*[A-Z0-9])", text):
        piece = text[begin:found.start() + 1]
        if ABBREVIATION.search(piece):
            continue
        out.append(text[begin:found.end()].strip())
        begin = found.end()
    out.append(text[begin:].strip())
    return [one for one in out if len(WORD.findall(one)) >= 2]


def share(values, part):
    values = sorted(values)
    return values[min(len(values) - 1, int(part * len(values)))] if values else 0


class Page:
    def __init__(self, path, kind):
        self.path = str(path)
        text = path.read_text(encoding="utf-8", errors="replace")
        if kind == "markdown":
            self.blocks = markdown(enumerate(text.splitlines(), 1))
        elif kind == "rust":
            self.blocks = rust_docs(text)
        else:
            self.blocks = strings(text)
        self.example = bool(EXAMPLE.search(text))
        self.inner = len(INNER.findall(text)) if kind == "markdown" else 0
        self.found = []        # (line, sentence, words, [(private word, instead)], headless)
        self.semicolons = self.headless = self.passive = self.spoken = self.you = 0
        self.private = []
        for block in self.blocks:
            said = plain(block.text)
            if block.prose:
                self.spoken += len(SPOKEN.findall(said))
                self.you += len(YOU.findall(said))
            # Only full sentences are measured; a bullet of two words is no sentence, nor is a table cell.
            for one in sentences(said) if block.prose else [said]:
                hits = [(word, instead) for pattern, word, instead in PRIVATE if pattern.search(one)]
                self.private += [(block.line, word, instead) for word, instead in hits]
                if not block.prose:
                    continue
                first = bool(HEADLESS.search(one)) and not one.rstrip(")*\"' ").endswith("?")
                inside = len(HEADLESS_INSIDE.findall(one))
                self.headless += first + inside
                self.semicolons += one.count(";")
                self.passive += bool(PASSIVE.search(one))
                self.found.append((block.line, one, len(WORD.findall(one)), hits, first + inside))
        self.lengths = [words for _, _, words, _, _ in self.found]
        self.words = sum(self.lengths)


def measure(pages, name):
    lengths = [one for page in pages for one in page.lengths]
    words = sum(lengths)
    thousand = words / 1000 or 1
    return {
        "name": name,
        "pages": len(pages),
        "words": words,
        "mean": sum(lengths) / len(lengths) if lengths else 0,
        "p90": share(lengths, 0.9),
        "over30": sum(one > 30 for one in lengths),
        "over30_share": 100 * sum(one > 30 for one in lengths) / len(lengths) if lengths else 0,
        "semicolons": sum(page.semicolons for page in pages) / thousand,
        "headless": sum(page.headless for page in pages) / thousand,
        "private": sum(len(page.private) for page in pages),
        "private_rate": sum(len(page.private) for page in pages) / thousand,
        "passive": 100 * sum(page.passive for page in pages) / len(lengths) if lengths else 0,
        "example": 100 * sum(page.example for page in pages) / len(pages) if pages else 0,
        "spoken": sum(page.spoken for page in pages) / thousand,
        "you": sum(page.you for page in pages) / thousand,
        "inner": sum(page.inner for page in pages),
    }


COLUMNS = [("words", "words", "d"), ("mean", "mean", ".1f"), ("p90", "p90", "d"), ("over30", "> 30", "d"),
           ("over30_share", "> 30 %", ".0f"), ("semicolons", "; /1000", ".1f"), ("headless", "headless /1000", ".1f"),
           ("private", "private", "d"), ("private_rate", "private /1000", ".1f"), ("passive", "passive %", ".0f"),
           ("spoken", "“for example” /1000", ".1f"),
           ("you", "“you” /1000", ".1f"), ("example", "pages with code or example %", ".0f"), ("inner", "test names, paths, hashes", "d")]


def table(measured, as_markdown=False):
    head = ["file"] + [title for _, title, _ in COLUMNS]
    body = [[one["name"]] + [format(one[key], form) for key, _, form in COLUMNS] for one in measured]
    if as_markdown:
        print("| " + " | ".join(head) + " |\n|" + "---|" + "---:|" * len(COLUMNS))
        for row in body:
            print("| " + " | ".join(row) + " |")
        return
    widths = [max(len(row[at]) for row in [head] + body) for at in range(len(head))]
    for row in [head, ["-" * width for width in widths]] + body:
        print("  ".join(cell.ljust(width) if at == 0 else cell.rjust(width) for at, (cell, width) in enumerate(zip(row, widths))))


SKIPPED = {"target", "node_modules", ".git", "out", "vendor", "third_party", "__pycache__"}


def gather(paths, kind):
    endings = {".md", ".mdx"} if kind == "markdown" else {".rs"}
    for given in map(Path, paths):
        if given.is_file():
            yield given
            continue
        if not given.is_dir():
            sys.exit(f"prose.py: no file or folder {given}")
        for path in sorted(one for one in given.rglob("*") if one.suffix in endings):
            inside = path.relative_to(given).parts
            if not SKIPPED & set(inside) and not (kind == "strings" and "tests" in inside):
                yield path


ROOT = Path(__file__).resolve().parents[1]
CEILINGS = ROOT / "xtask/prose.txt"
TITLE = """# Ceilings of prose that only fall: `kind file: sentences over 30 words, semicolons, headless clauses, private words, inner names`.
# A file without a row has none of them. Of a page the mean sentence has at most 18 words, and nine of ten have at most 30.
# `python3 xtask/prose.py --check` compares every file with this, and `--check --bless` lowers it.
"""
COUNTED = {"page": ("markdown", ["README.md", "CHANGELOG.md", "CONTRIBUTING.md", "SECURITY.md", "docs", "protocol/FORMAT.md"]),
           "comments": ("rust", ["core", "protocol", "firmware", "host-sim", "examples", "xtask"]),
           "strings": ("strings", ["core", "protocol", "firmware", "host-sim", "tests", "examples", "xtask"])}
# What users and readers of an API do not read.
TESTS = {"tests", "benches", "fuzz"}
# Of pages only: the most words of a mean sentence, and of nine in ten.
MEAN, P90 = 18, 30


def counts(page):
    return [sum(one > 30 for one in page.lengths), page.semicolons, page.headless, len(page.private), page.inner]


def ceilings(text):
    rows = (line.rsplit(": ", 1) for line in text.splitlines() if line and not line.startswith("#"))
    return {name: [int(count) for count in numbers.split()] for name, numbers in rows}


def git(*words):
    return subprocess.run(["git", *words], cwd=ROOT, capture_output=True, text=True)


def before():
    """The ceilings of the commit before, under the names that files have now: a change only lowers them."""
    for revision in ["HEAD", "HEAD^"]:
        shown = git("show", f"{revision}:{CEILINGS.relative_to(ROOT)}")
        if shown.returncode == 0 and shown.stdout != CEILINGS.read_text(encoding="utf-8"):
            renamed = git("diff", "--name-status", "--find-renames=40%", "--diff-filter=R", revision).stdout
            moved = dict(line.split("\t")[1:] for line in renamed.splitlines())
            old = (name.split(" ", 1) + [row] for name, row in ceilings(shown.stdout).items())
            return {f"{kind} {moved.get(path, path)}": row for kind, path, row in old}
    return None


def check(bless):
    measured, beyond = {}, []
    for kind, (form, places) in COUNTED.items():
        for path in gather([ROOT / place for place in places if (ROOT / place).exists()], form):
            if form != "markdown" and TESTS & set(path.relative_to(ROOT).parts[1:]):
                continue
            page = Page(path, form)
            name = f"{kind} {path.relative_to(ROOT)}"
            measured[name] = counts(page)
            if kind == "page" and page.words >= 100:
                mean, p90 = page.words / len(page.lengths), share(page.lengths, 0.9)
                if mean > MEAN or p90 > P90:
                    beyond.append(f"{name}: mean {mean:.1f}, 90 % {p90} words; at most {MEAN} and {P90}")
    none = [0] * 5
    allowed = ceilings(CEILINGS.read_text(encoding="utf-8")) if CEILINGS.exists() else measured
    grown = [name for name, now in measured.items() if any(a > b for a, b in zip(now, allowed.get(name, none)))]
    for name in grown:
        beyond.append(f"{name}: {measured[name]} of {allowed.get(name, none)}; see `prose.py --worst 20` and `--private`")
    if bless:
        lowered = {name: [min(pair) for pair in zip(now, allowed.get(name, none))] for name, now in measured.items()}
        rows = [f"{name}: {' '.join(map(str, now))}\n" for name, now in sorted(lowered.items()) if any(now)]
        CEILINGS.write_text(TITLE + "".join(rows), encoding="utf-8")
    elif (old := before()) is not None:
        rose = [name for name, now in allowed.items() if any(a > b for a, b in zip(now, old.get(name, none)))]
        beyond += [f"{name}: its ceiling is above that of the commit before" for name in rose]
    print("\n".join(beyond), file=sys.stderr, end="\n" if beyond else "")
    return 1 if beyond else 0


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("paths", nargs="*", help="files or folders")
    parser.add_argument("--kind", choices=["markdown", "rust", "strings"], default="markdown")
    parser.add_argument("--worst", type=int, default=0, metavar="N", help="print the N worst sentences instead of the table")
    parser.add_argument("--private", action="store_true", help="print every private word with file:line and what to write instead")
    parser.add_argument("--words", action="store_true", help="print the word list as a Markdown table")
    parser.add_argument("--compare", nargs="+", metavar="NAME=PATH[,PATH…]", help="a row for each set of pages")
    parser.add_argument("--markdown", action="store_true", help="print the table as Markdown")
    parser.add_argument("--json", action="store_true")
    parser.add_argument("--check", action="store_true", help="compare every file of this repository with its ceilings")
    parser.add_argument("--bless", action="store_true", help="with --check: lower the ceilings to what is measured")
    parser.add_argument("--total", action="store_true", help="print the total row only")
    for name, what in [("mean", "words in a mean sentence"), ("p90", "words in the 90th percentile sentence"), ("over30", "sentences over 30 words"),
                       ("semicolons", "semicolons per 1000 words"), ("headless", "headless clauses per 1000 words"),
                       ("private", "private words"), ("passive", "percent of passive sentences"), ("inner", "test names, source paths and hashes")]:
        parser.add_argument(f"--max-{name}", type=float, metavar="X", help=f"exit 1 if a page has more {what}")
    parser.add_argument("--least-words", type=int, default=100, help="bounds on means and rates apply to pages of this many words or more [100]")
    given = parser.parse_args()
    if given.check:
        return check(given.bless)
    if given.words:
        print("| do not write | write | field's term, or why |\n|---|---|---|")
        for _, word, instead, why in rows():
            print(f"| {word} | {instead} | {why or ''} |")
        return 0
    if given.compare:
        measured = []
        for one in given.compare:
            name, _, paths = one.partition("=")
            measured.append(measure([Page(path, given.kind) for path in gather(paths.split(","), given.kind)], name))
        table(measured, given.markdown)
        return 0
    pages = [Page(path, given.kind) for path in gather(given.paths, given.kind)]
    pages = [page for page in pages if page.found or page.private]
    if not pages:
        parser.error("no prose in what was given")
    if given.private:
        for page in pages:
            for line, word, instead in page.private:
                print(f"{page.path}:{line}: {word} -> {instead}")
        return 0
    if given.worst:
        every = [(words + 6 * len(hits) + 5 * headless, page.path, line, words, hits, headless, one)
                 for page in pages for line, one, words, hits, headless in page.found]
        for _, path, line, words, hits, headless, one in sorted(every, key=lambda row: -row[0])[:given.worst]:
            marks = [f"{words} words"] + [f"{headless} headless"] * bool(headless) + [f"{word} -> {instead}" for word, instead in hits]
            print(f"{path}:{line}: {'; '.join(marks)}\n    {one}\n")
        return 0
    measured = [measure([page], page.path) for page in pages]
    measured.append(measure(pages, f"total of {len(pages)}"))
    if given.json:
        print(json.dumps(measured, indent=1, ensure_ascii=False))
    else:
        table(measured[-1:] if given.total else measured, given.markdown)
    beyond = []
    for one in measured[:-1]:
        for name in ["mean", "p90", "over30", "semicolons", "headless", "private", "passive", "inner"]:
            most = getattr(given, f"max_{name}")
            rate = name in ("mean", "p90", "semicolons", "headless", "passive")
            if most is not None and one[name] > most and not (rate and one["words"] < given.least_words):
                beyond.append(f"{one['name']}: {name} {one[name]:.1f}, at most {most:g} allowed")
    print("\n".join(beyond), file=sys.stderr, end="\n" if beyond else "")
    return 1 if beyond else 0


if __name__ == "__main__":
    sys.exit(main())
