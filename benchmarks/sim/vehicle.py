"""For context: how fast MuJoCo simulates a robot like ours, four driven wheels on a plane at 250 Hz, with ten LiDAR scans a second of the same scene."""

import time

import mujoco
import numpy as np

from peer_mujoco import add_scene, many_rays

STEP = 1.0 / 250.0  # seconds
STEPS_PER_SCAN = 25
SCANS = 30
SPEED = 0.5  # metres a second
LIDAR = np.array([0.12, 0.0, 0.175])  # metres, from the middle of the robot at the ground
WHEEL = 0.06  # radius, metres

ROBOT = f"""
<mujoco>
  <option timestep="{STEP}" integrator="implicitfast"/>
  <worldbody>
    <geom type="plane" size="200 200 1"/>
    <body name="chassis" pos="0 0 {WHEEL}">
      <freejoint/>
      <geom type="box" size="0.15 0.1 0.05" pos="0 0 0.05" mass="8.2"/>
      {{wheels}}
    </body>
  </worldbody>
  <actuator>{{motors}}</actuator>
</mujoco>
"""


def model_of(triangles, most):
    wheels, motors = "", ""
    for index, (x, y) in enumerate([(0.1, 0.13), (0.1, -0.13), (-0.1, 0.13), (-0.1, -0.13)]):
        wheels += f"""<body pos="{x} {y} 0"><joint name="axle{index}" axis="0 1 0"/>
            <geom type="cylinder" size="{WHEEL} 0.025" zaxis="0 1 0" mass="0.5"/></body>"""
        motors += f'<velocity joint="axle{index}" kv="0.5"/>'
    spec = mujoco.MjSpec.from_string(ROBOT.format(wheels=wheels, motors=motors))
    add_scene(spec, triangles, most)
    return spec.compile()


def real_time_factor(dump, most):
    """Simulated seconds for each CPU second, driving straight on from where the dump's first scan was made, and the metres driven."""
    model = model_of(dump.triangles, most)
    data = mujoco.MjData(model)
    data.qpos[:2] = dump.origins[0, :2]
    data.ctrl[:] = SPEED / WHEEL
    directions = dump.directions[dump.shared_origins()[0]].astype(np.float64)
    geoms, found = np.empty(len(directions), dtype=np.int32), np.empty(len(directions))
    body = model.body("chassis").id
    begin = time.process_time()
    for _ in range(SCANS):
        mujoco.mj_step(model, data, STEPS_PER_SCAN)
        turn = data.xmat[body].reshape(3, 3)
        origin = data.xpos[body] + turn @ (LIDAR - [0.0, 0.0, WHEEL])
        many_rays(model, data, origin, (directions @ turn.T).ravel(), geoms, found, dump.max_range, exclude=body)
    seconds = time.process_time() - begin
    if data.warning[mujoco.mjtWarning.mjWARN_BADQACC].number:
        raise RuntimeError("MuJoCo's robot became unstable: its real-time factor would mean nothing")
    driven = float(np.linalg.norm(data.qpos[:2] - dump.origins[0, :2]))
    return {
        "real_time_factor": SCANS * STEPS_PER_SCAN * STEP / seconds,
        "rays_per_scan": len(directions),
        "driven_m": driven,
    }
