"""Runs CalculiX (ccx) on a deck and reads what it printed.  Python 3 standard library only.

Results are read from the .dat file (*NODE PRINT), not from the .frd file: it has the same
digits (seven), the sums over a set, and no expansion of axisymmetric elements.
"""
import os
import re
import subprocess
import time


def run(job, folder, threads=1, timeout=3000):
    """Runs ccx on folder/job.inp. Returns seconds; raises RuntimeError unless it finishes."""
    env = dict(os.environ, OMP_NUM_THREADS=str(threads), OPENBLAS_NUM_THREADS="1")
    start = time.time()
    log = os.path.join(folder, job + ".log")
    with open(log, "w") as out:
        status = subprocess.run(["ccx", job], cwd=folder, env=env, stdout=out,
                                stderr=subprocess.STDOUT, timeout=timeout).returncode
    text = open(log, errors="replace").read()
    if status != 0 or "Job finished" not in text:
        errors = [line.strip() for line in text.splitlines() if "*ERROR" in line]
        raise RuntimeError("ccx %s: exit status %d; %s" % (job, status, "; ".join(errors[:3]) or log))
    return time.time() - start


def read_dat(job, folder):
    """[(quantity, set, time, {node: (x, y, z)}, total or None)], in the order of the file."""
    blocks = []
    head = re.compile(r"^\s*(total force|displacements|forces) \(.*\) for set (\S+) and time\s+(\S+)")
    for line in open(os.path.join(folder, job + ".dat")):
        match = head.match(line)
        if match:
            blocks.append([match.group(1), match.group(2), float(match.group(3)), {}, None])
            continue
        words = line.split()
        if not blocks or not words:
            continue
        if blocks[-1][0] == "total force" and len(words) == 3:
            blocks[-1][4] = tuple(float(w) for w in words)
        elif len(words) == 4 and words[0].isdigit():
            blocks[-1][3][int(words[0])] = tuple(float(w) for w in words[1:])
        else:
            blocks.append(["other", "", 0.0, {}, None])
    return blocks


def increments(job, folder):
    """Increments and Newton iterations that ccx took, from its .sta file."""
    steps = iterations = 0
    for line in open(os.path.join(folder, job + ".sta")):
        words = line.split()
        if len(words) >= 6 and words[0].isdigit():
            steps += 1
            iterations += int(words[3])
    return steps, iterations
