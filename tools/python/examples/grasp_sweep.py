"""Two fingers squeeze a tennis ball: force and stiffness against travel, for two sizes of finger.

PYTHONPATH=build/python /usr/bin/python3 tools/python/examples/grasp_sweep.py [grasp_sweep.png]
"""
import os
import sys

import darboux

data = os.path.join(os.path.dirname(__file__), "..", "..", "..", "data")
ball = darboux.Scene.load(os.path.join(data, "tennis_ball.yaml"))  # mm, N, MPa
ball["surface"]["frequency"] = 6  # 1,086 unknowns: a few seconds for all of it
del ball["expect"]
curves = {}
print("radius mm  travel mm  force N  stiffness N/mm  contact mm2  stored mJ")
for radius in (3, 10):
    result = None
    for travel in (2, 4, 6):
        for finger in ball["fingers"]:
            finger["shape"]["radius"] = radius
            finger["motion"]["travel"] = travel
        result = ball.solve(start=result, check=True)  # from where the last one ended
        top, grasp = result.fingers["top"], result.grasp
        curves.setdefault(radius, []).append((travel, top["normal_force"]))
        print(f"{radius:9}  {travel:9}  {top['normal_force']:7.4f}  {top['stiffness']:14.4f}"
              f"  {top['contact_area']:11.2f}  {grasp['stored_energy']:9.4f}")  # fmt: skip
if len(sys.argv) > 1:
    import matplotlib.pyplot as plot  # Debian: python3-matplotlib

    for radius, points in curves.items():
        plot.plot(*zip(*points), marker="o", label=f"fingers of {radius} mm")
    plot.xlabel("travel of each finger, mm")
    plot.ylabel("force, N")
    plot.legend()
    plot.savefig(sys.argv[1])
