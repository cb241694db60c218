"""Checks that alerts and dashboard use only existing metrics. Usage: watching_test.py PROJECT"""
import json
import pathlib
import re
import shutil
import subprocess
import sys

project = pathlib.Path(sys.argv[1])
serving = project / "docker/serving"
known = set(re.findall(r'"((?:multitetra|process)_\w+)"', (project / "server/operations/prometheus_metrics.cpp").read_text()))
dashboard = json.loads((serving / "dashboard.json").read_text())
expressions = [target["expr"] for panel in dashboard["panels"] for target in panel["targets"]]
texts = "\n".join([*expressions, (serving / "alerts.yml").read_text()])
names = set(re.findall(r"\b(?:multitetra|process)_\w+", texts))
unknown = {name for name in names if re.sub(r"_(bucket|count|sum)$", "", name) not in known}
assert not unknown, f"no metric named {sorted(unknown)}"
assert len(names) > 15, "alerts and dashboard were found"
ids = [panel["id"] for panel in dashboard["panels"]]
assert len(ids) == len(set(ids)), "panels have numbers of their own"
if shutil.which("promtool"):
    subprocess.run(["promtool", "check", "rules", serving / "alerts.yml"], check=True)
else:
    print("!! LEFT OUT: promtool is not installed: the rules' syntax is NOT TESTED.")
print(f"{len(names)} names of metrics are known.")
