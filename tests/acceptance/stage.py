"""The robot of check_diagnose.py and check_plan.py: a rotary stage with a slide."""
import math

URDF = """<robot name="stage"><link name="base"/><link name="table"/><link name="tip"/>
<joint name="turn" type="revolute"><parent link="base"/><child link="table"/><axis xyz="0 0 1"/>
<limit lower="-3" upper="3" effort="10" velocity="9"/></joint>
<joint name="reach" type="prismatic"><parent link="table"/><child link="tip"/><axis xyz="1 0 0"/>
<limit lower="-1" upper="1" effort="10" velocity="1"/></joint></robot>
"""
SPEC = """# a rotary stage with a slide
qerr: 1
robot: {urdf: stage.urdf}   # beside this file
encoders:
  turn: {counts_per_rev: 4000, gear_ratio: 3}
  reach: {resolution: 10 um}  # a scale
configurations: {method: sobol, count: 100}
"""
STEP = {"turn": 2 * math.pi / 12000, "reach": 1e-5}  # resolution of the encoders at the joints [rad, m]
