"""How well hidden effects are found: cases simulated at a fidelity and in forms that the grey box does not have, judged against their truth.

python benchmarks/hidden.py --cases 20                       some cases, then the table; goes on where it was stopped
python benchmarks/hidden.py --cases 400 --jobs 4 --peers     all of it, with the other methods on the same cases
python benchmarks/hidden.py --cases 0 --near 160             where one effect begins to be found: sizes about there, beside what was judged
python benchmarks/hidden.py --only table                     the table and the figures again, from what is written down
"""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import Any

from hidden_effects.judge import judged, judged_near
from hidden_effects.recipe import SHARES
from hidden_effects.report import report
from hidden_effects.work import do, done, seeds

OUT = Path("outputs/bench_hidden")


def arguments() -> argparse.Namespace:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--cases", type=int, default=400, help="how many")
    parser.add_argument("--near", type=int, default=0, help="how many more with one hidden effect of a size at which its detection is decided")
    parser.add_argument("--seed0", type=int, default=0, help="first seed")
    parser.add_argument("--kinds", nargs="+", choices=SHARES, default=list(SHARES), help="only these")
    parser.add_argument("--jobs", type=int, default=2, help="processes")
    parser.add_argument("--peers", action="store_true", help="ask PySINDy, a stepwise regression and a BIC ranking as well")
    parser.add_argument("--only", choices=["table"], help="judge nothing")
    parser.add_argument("--out", type=Path, default=OUT, help="folder of results.jsonl, table.md and the figures")
    return parser.parse_args()


def main() -> None:
    asked = arguments()
    ours, limits, others = (asked.out / f"{name}.jsonl" for name in ("results", "near", "peers"))
    if asked.only is None:
        wanted = list(seeds(asked.cases, asked.seed0, asked.kinds))
        do(judged, wanted, ours, asked.jobs)
        do(judged_near, list(seeds(asked.near, asked.seed0, ["one"])), limits, asked.jobs)
        if asked.peers:
            do(ask, wanted, others, asked.jobs)
    rows, answers = list(done(ours).values()), list(done(others).values())
    print(report(rows, answers, asked.out, list(done(limits).values())))


def ask(seed: int) -> dict[str, Any]:
    """The other methods' answers; what they import takes seconds, and is missing where nobody asked for it."""
    from hidden_effects.peers.ask import asked

    return asked(seed)


if __name__ == "__main__":
    main()
