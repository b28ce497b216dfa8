#!/usr/bin/env python3
"""Runs other LiDAR(-inertial) odometries on one of our logs.

    python peers.py LOG.mcap --out FOLDER [--only NAME ...]

For each peer it writes

* FOLDER/NAME.tum, a line `seconds x y z qx qy qz qw` for each scan: the pose
  of base_link in the peer's own odometry frame, with the time that the pose
  refers to;
* FOLDER/NAME.log, what the peer printed;
* FOLDER/NAME.json, the number of poses, the CPU milliseconds per scan (median
  and 99th percentile) and the peer's version, or {"error": "..."} where the
  peer failed.

Each peer runs in a process of its own: one that crashes does not take the
others along, and one that keeps state in C++ statics (DLIO does) starts clean.

What the CPU time counts: all threads of the process, from handing the peer the
IMU samples of a scan and the scan itself until its pose is there, with the
copy of the points that its Python binding makes. Reading and decoding the log,
the range filter and building arrays are not counted. Every peer is told to use
one thread. A scan is 20,000 rays; where rays end in the sky it holds fewer
points, and the peer gets only those.
"""

import argparse
import json
import os
import subprocess
import sys
import time
from dataclasses import dataclass
from importlib.metadata import version
from pathlib import Path

ONE_THREAD = {
    "OMP_NUM_THREADS": "1",
    "OPENBLAS_NUM_THREADS": "1",
    "MKL_NUM_THREADS": "1",
}
# The libraries read these when they are loaded, so before the imports below.
os.environ.update(ONE_THREAD)

import numpy as np  # noqa: E402

IMU_TOPIC = "/livox/imu"
LIDAR_TOPIC = "/livox/lidar"

# Where the sensors sit in base_link; neither is rotated.
IMU_IN_BASE = np.array([0.12, 0.0, 0.185])
LIDAR_IN_BASE = np.array([0.12, 0.0, 0.235])

MIN_RANGE, MAX_RANGE = 0.3, 70.0

# The robot drops onto its wheels in the first samples of a log (14 m/s^2) and
# then stands still until 2 s. Most peers take their IMU biases from their
# first samples, so all of them start after the drop.
SKIP_NS = 500_000_000

# The IMU's noise, in continuous time.
GYRO_NOISE, ACCEL_NOISE = 2e-4, 2e-3  # rad/s/sqrt(Hz), m/s^2/sqrt(Hz)
GYRO_WALK, ACCEL_WALK = 1e-5, 1e-4

TIMEOUT_S = 3600


# ---------------------------------------------------------------- the log


@dataclass
class Scan:
    """One scan, each point in the LiDAR's frame at its own instant."""

    start: int  # header stamp: the first ray, ns
    xyz: np.ndarray  # (N, 3) float32, m
    offsets: np.ndarray  # (N,) uint32 ns after the start

    @property
    def end(self):
        """The time of the last point, ns."""
        return self.start + int(self.offsets.max())


def stamp_ns(header):
    """A ROS header's stamp in nanoseconds."""
    return header.stamp.sec * 1_000_000_000 + header.stamp.nanosec


def decode_scan(msg):
    """A PointCloud2 as arrays, without points out of the sensor's range."""
    kinds = {2: "u1", 6: "<u4", 7: "<f4"}
    layout = np.dtype(
        {
            "names": [f.name for f in msg.fields],
            "formats": [kinds[f.datatype] for f in msg.fields],
            "offsets": [f.offset for f in msg.fields],
            "itemsize": msg.point_step,
        }
    )
    points = msg.data.view(layout)
    xyz = np.stack([points["x"], points["y"], points["z"]], axis=1)
    distance = np.linalg.norm(xyz, axis=1)
    keep = (distance > MIN_RANGE) & (distance < MAX_RANGE)
    return Scan(stamp_ns(msg.header), xyz[keep], points["offset_time"][keep])


def decode_imu(msg):
    """An Imu message as (ns, specific force, angular velocity)."""
    a, w = msg.linear_acceleration, msg.angular_velocity
    return stamp_ns(msg.header), np.array([a.x, a.y, a.z]), np.array([w.x, w.y, w.z])


def messages(log):
    """The IMU samples and scans of a log in the order they were recorded."""
    from rosbags.highlevel import AnyReader
    from rosbags.typesys import Stores, get_typestore

    with AnyReader([log], default_typestore=get_typestore(Stores.ROS2_HUMBLE)) as reader:
        wanted = [c for c in reader.connections if c.topic in (IMU_TOPIC, LIDAR_TOPIC)]
        for connection, _, raw in reader.messages(connections=wanted):
            msg = reader.deserialize(raw, connection.msgtype)
            if connection.topic == IMU_TOPIC:
                yield decode_imu(msg)
            else:
                yield decode_scan(msg)


def frames(log):
    """Yields (scan, IMU samples since the last scan), once the IMU covers it.

    The samples end with the first one at or after the scan's last point, so
    that a peer can interpolate over the whole scan and sees no further ahead.
    """
    first, samples, waiting = None, [], []
    for item in messages(log):
        now = item.start if isinstance(item, Scan) else item[0]
        first = now if first is None else first
        if now < first + SKIP_NS:
            continue
        if isinstance(item, Scan):
            waiting.append(item)
        else:
            samples.append(item)
        while waiting and samples and samples[-1][0] >= waiting[0].end:
            scan = waiting.pop(0)
            ready = next(i for i, s in enumerate(samples) if s[0] >= scan.end) + 1
            yield scan, samples[:ready]
            samples = samples[ready:]


# ---------------------------------------------------------------- geometry


def translation(offset):
    """A 4x4 transform that only shifts."""
    transform = np.eye(4)
    transform[:3, 3] = offset
    return transform


def to_base(pose, sensor_in_base):
    """The pose of base_link from that of an unrotated sensor on it.

    The odometry frame moves along: it is where base_link was when the sensor
    was at the peer's origin.
    """
    return translation(sensor_in_base) @ pose @ translation(-sensor_in_base)


def quaternion(rotation):
    """The quaternion (x, y, z, w) of a rotation matrix."""
    k = np.array(
        [
            rotation[2, 1] - rotation[1, 2],
            rotation[0, 2] - rotation[2, 0],
            rotation[1, 0] - rotation[0, 1],
        ]
    )
    s = rotation + rotation.T
    q = np.empty((4, 4))
    q[:3, :3] = s + np.eye(3) * (1 - np.trace(rotation))
    q[:3, 3] = q[3, :3] = k
    q[3, 3] = 1 + np.trace(rotation)
    # Each row is the quaternion times four of its own entries: take the largest.
    row = q[np.argmax(np.diag(q))]
    return row / np.linalg.norm(row) * (1 if row[3] >= 0 else -1)


# ---------------------------------------------------------------- the peers
#
# A peer has `prepare(scan, samples)`, not timed, which puts the data in the
# form the peer takes, and `run(prepared)`, timed, which returns (ns, 4x4 pose
# of base_link), or None while the peer still starts up.


class KissIcp:
    """KISS-ICP: LiDAR only, deskewing with the last motion."""

    package = "kiss-icp"
    # Tried on the first 70 s of small.mcap and 100 s of street.mcap: 0.5, 0.7 (its own
    # rule, a hundredth of the range) and 1.0 m. The coarser the worse, by 0.3 to
    # 0.8 cm a step (aligned over the whole run), but 0.7 takes a third to a half
    # of the time, and 0.5 is too slow for one core on street.mcap: its own rule. It stretches
    # the points' times over the whole of the last motion, too far where the
    # first or last rays hit nothing; points beyond the range at both ends of
    # the 100 ms would mend that, and changed nothing.
    settings = {"voxel_size": 0.7}

    def __init__(self):
        from kiss_icp.config import KISSConfig
        from kiss_icp.kiss_icp import KissICP

        config = KISSConfig()
        config.data.min_range, config.data.max_range = MIN_RANGE, MAX_RANGE
        config.data.deskew = True
        config.mapping.voxel_size = self.settings["voxel_size"]
        config.registration.max_num_threads = 1
        self.odometry = KissICP(config)

    def prepare(self, scan, _samples):
        return scan.end, scan.xyz.astype(np.float64), scan.offsets * 1e-9

    def run(self, prepared):
        # Deskewing moves the points to the time of the last one (it leaves
        # that point as it was), so the pose is the one at that time.
        end, xyz, seconds = prepared
        self.odometry.register_frame(xyz, seconds)
        return end, to_base(self.odometry.last_pose, LIDAR_IN_BASE)


class RkoLio:
    """RKO-LIO: point-to-point ICP with the IMU as prior and for the attitude."""

    package = "rko_lio"
    # Tried on small.mcap and street.mcap: 0.5 and 1.0 m (its default), with and without the
    # second downsampling, which its documentation advises against for sparse
    # LiDARs.
    # It takes no noise parameters.
    settings = {"voxel_size": 0.5, "double_downsample": False}

    def __init__(self):
        from rko_lio.config import LIOConfig
        from rko_lio.lio import LIO

        config = LIOConfig(
            min_range=MIN_RANGE,
            max_range=MAX_RANGE,
            max_num_threads=1,
            # Attitude and biases from standing still.
            initialization_phase=True,
            **self.settings,
        )
        self.lio = LIO(config)
        self.imu_in_base = translation(IMU_IN_BASE)
        self.lidar_in_base = translation(LIDAR_IN_BASE)

    def prepare(self, scan, samples):
        times = scan.start + scan.offsets.astype(np.int64)
        return scan.end, scan.xyz.astype(np.float64), times, samples

    def run(self, prepared):
        # The pose refers to the end of the scan: the points are deskewed to
        # `end_time_ns`, and that is the time the pose is filed under.
        end, xyz, times, samples = prepared
        for ns, accel, gyro in samples:
            self.lio.add_imu_measurement(accel, gyro, ns, self.imu_in_base)
        self.lio.register_scan(xyz, times, self.lidar_in_base, end_time_ns=end)
        return end, self.lio.pose()


class Se3Lio:
    """SE(3)-LIO: iterated Kalman filter on SE(3) with a voxel map of planes."""

    package = "se3-lio"
    # LiDAR noise as in the configurations its authors publish (the package's
    # defaults are 0.001 and 0.01), and a map of 0.5 m, better than the default
    # 1.0 on the first 70 s of small.mcap and 80 s of street.mcap. Tried on street.mcap
    # only: planes 0.05 thick, as in some of those configurations (same error
    # aligned over the whole run, 46 cm instead of 3 aligned at its start), and
    # the IMU's own noise, 0.02 and 0.002 per sample, instead of the defaults of
    # 0.1 which all of them keep (0.05 cm better and 0.3 cm worse).
    settings = {
        "lidar_range_noise": 0.02,
        "lidar_angle_noise": 0.1,
        "voxel_map_resolution": 0.5,
    }

    def __init__(self):
        from se3_lio import SE3LIO, SE3LIOConfig

        lidar_in_imu = translation(LIDAR_IN_BASE - IMU_IN_BASE)
        self.odometry = SE3LIO(SE3LIOConfig(**self.settings), lidar_in_imu)
        self.held = []

    def prepare(self, scan, samples):
        # Its own synchronizer gives a scan the samples before the scan's end
        # and keeps the one after it for the next.
        rows = self.held + [[ns * 1e-9, *accel, *gyro] for ns, accel, gyro in samples]
        end = scan.end * 1e-9
        self.held = [r for r in rows if r[0] >= end]
        imu = np.array([r for r in rows if r[0] < end])
        return scan.end, scan.xyz.astype(np.float64), scan.offsets * 1e-9, imu, scan.start * 1e-9

    def run(self, prepared):
        # The state's own stamp is the time of the last point.
        end, xyz, seconds, imu, start = prepared
        state, _ = self.odometry.register_frame(xyz, seconds, imu, start)
        return end, to_base(np.array(state.pose), IMU_IN_BASE)


class Evalio:
    """A pipeline of evalio, which gives poses of the IMU.

    Of evalio's pipelines only DLIO and LIO-SAM use the IMU; CT-ICP, FORM,
    GenZ-ICP, KISS-ICP, LOAM and MAD-ICP are LiDAR only and left out here.
    LIO-SAM is left out because it does not work here: it sorts the points by
    laser and azimuth into an image and looks for edges along its rows, a
    MID-360 does not scan in rows, and evalio gives no way to select LIO-SAM's
    own order for Livox. It was 2 m to 112 m off on five of seven logs.
    """

    package = "evalio"
    pipeline = ""
    settings = {}

    def __init__(self):
        from evalio import types
        from evalio._cpp import pipelines

        self.types = types
        self.pipe = getattr(pipelines, self.pipeline)()
        self.pipe.set_imu_params(
            types.ImuParams(
                gyro=GYRO_NOISE,
                accel=ACCEL_NOISE,
                gyro_bias=GYRO_WALK,
                accel_bias=ACCEL_WALK,
                gravity=np.array([0, 0, -9.80665]),
                rate=100.0,
            )
        )
        self.pipe.set_lidar_params(
            types.LidarParams(
                num_rows=4, num_columns=5000, min_range=MIN_RANGE, max_range=MAX_RANGE, rate=10.0
            )
        )
        lidar_in_imu = translation(LIDAR_IN_BASE - IMU_IN_BASE)
        self.pipe.set_imu_T_lidar(types.SE3.from_mat(lidar_in_imu))
        # evalio lists its pipelines' defaults but sets only what it is given;
        # what is left out keeps other values from the C++ (some of them 0).
        self.pipe.set_params({**self.pipe.default_params(), **self.settings})
        self.pipe.initialize()

    def prepare(self, scan, samples):
        imu = [
            self.types.ImuMeasurement(self.types.Stamp.from_nsec(ns), gyro, accel)
            for ns, accel, gyro in samples
        ]
        return scan, self.measurement(scan), imu

    def measurement(self, scan):
        """The scan as evalio's own type, made by evalio from packed bytes."""
        from evalio._cpp import helpers as h

        names = ["x", "y", "z", "t"]
        layout = np.dtype(list(zip(names, ["<f4", "<f4", "<f4", "<u4"])))
        points = np.empty(len(scan.xyz), layout)
        points["x"], points["y"], points["z"] = scan.xyz.T
        points["t"] = scan.offsets
        kinds = [h.DataType.FLOAT32] * 3 + [h.DataType.UINT32]
        fields = [
            h.Field(name=n, datatype=k, offset=layout.fields[n][1]) for n, k in zip(names, kinds)
        ]
        cloud = h.PointCloudMetadata(
            stamp=self.types.Stamp.from_nsec(scan.start),
            width=len(points),
            height=1,
            point_step=layout.itemsize,
            row_step=len(points) * layout.itemsize,
            is_bigendian=0,
            is_dense=1,
        )
        return h.pc2_to_evalio(cloud, fields, points.tobytes())

    def run(self, prepared):
        scan, measurement, imu = prepared
        for sample in imu:
            self.pipe.add_imu(sample)
        self.pipe.add_lidar(measurement)
        self.finish()
        poses, ns = self.pipe.saved_estimates(), self.pose_time(scan)
        if not poses or ns is None:
            return None
        return ns, to_base(poses[-1][1].to_mat(), IMU_IN_BASE)

    def finish(self):
        """Waits for what the pipeline still does behind the call."""

    def pose_time(self, scan):
        """The time the pose refers to, ns, or None before the first pose."""
        raise NotImplementedError


class Dlio(Evalio):
    """DLIO: GICP against keyframes and a geometric observer, by evalio."""

    pipeline = "DLIO"
    # Its defaults but for the start. Tried: points thinned to 0.1 m instead of
    # 0.25 m (0.1 cm better on small.mcap, 0.2 cm worse on street.mcap, dearer), and on
    # the first 80 s of street.mcap 0.5 m and neighbours up to 1 m (no better).
    # It takes no noise parameters and has no limits of range.
    settings = {
        # The robot stands still until 2 s, DLIO's 3 s are too long.
        "imu_calib_time": 1.0,
        # The points' times are right: do not shift the first to the stamp.
        "time_offset": False,
        "crop_size": MIN_RANGE,
    }
    # Before this it calibrates, and evalio reports a pose that is not set yet.
    starting_ns = 1_200_000_000
    first = None

    def run(self, prepared):
        found = super().run(prepared)
        start = prepared[0].start
        self.first = self.first or start
        return found if start - self.first >= self.starting_ns else None

    def finish(self):
        # DLIO builds its submap in a thread. On a robot it has the rest of the
        # 100 ms for that; here it gets the time too, and its work is counted.
        for _ in range(40):
            before = time.process_time()
            time.sleep(0.002)
            if time.process_time() - before < 0.0005:
                return

    def pose_time(self, scan):
        # evalio files the pose under the scan's start, but it is DLIO's state
        # right after its update. DLIO deskews to the median of the scan's
        # distinct point times, and its observer draws the state towards that
        # pose, position and attitude, so that is the time it settles on.
        times = np.unique(scan.offsets)
        return scan.start + int(times[len(times) // 2])


PEERS = {
    "kiss-icp": KissIcp,
    "rko-lio": RkoLio,
    "se3-lio": Se3Lio,
    "dlio": Dlio,
}


# ---------------------------------------------------------------- running


def follow(peer, log):
    """Runs a peer over a log; returns its poses and CPU seconds per scan."""
    poses, seconds = [], []
    for scan, samples in frames(log):
        prepared = peer.prepare(scan, samples)
        before = time.process_time()
        found = peer.run(prepared)
        seconds.append(time.process_time() - before)
        if found is not None:
            poses.append(found)
    return poses, seconds


def tum_line(ns, pose):
    """A pose as a line of a TUM file."""
    values = [*pose[:3, 3], *quaternion(pose[:3, :3])]
    return f"{ns // 10**9}.{ns % 10**9:09d} " + " ".join(f"{v:.9f}" for v in values)


def work(name, log, out):
    """Runs one peer in this process and writes its two files."""
    kind = PEERS[name]
    poses, seconds = follow(kind(), log)
    if not poses:
        raise RuntimeError("no poses")
    if not np.isfinite([p for _, p in poses]).all():
        raise RuntimeError("a pose that is no number")
    (out / f"{name}.tum").write_text("".join(tum_line(*p) + "\n" for p in poses))
    p50, p99 = np.percentile(np.array(seconds) * 1e3, [50, 99])
    return {
        "scans": len(poses),
        "cpu_ms_p50": round(float(p50), 3),
        "cpu_ms_p99": round(float(p99), 3),
        "version": version(kind.package),
    }


def work_safely(name, log, out):
    """Like `work`, but an exception becomes the result."""
    try:
        result = work(name, log, out)
    except Exception as error:  # whatever a peer throws
        result = {"error": f"{type(error).__name__}: {error}"}
    write_result(name, out, result)


def write_result(name, out, result):
    """Writes a peer's JSON."""
    (out / f"{name}.json").write_text(json.dumps(result) + "\n")


def spawn(name, log, out):
    """Runs one peer in a process of its own and returns its result."""
    for old in (out / f"{name}.tum", out / f"{name}.json"):
        old.unlink(missing_ok=True)
    command = [sys.executable, __file__, str(log), "--out", str(out), "--worker", name]
    with (out / f"{name}.log").open("w") as output:
        try:
            code = subprocess.run(
                command, stdout=output, stderr=subprocess.STDOUT, timeout=TIMEOUT_S
            ).returncode
            failure = f"ended with {code}"
        except subprocess.TimeoutExpired:
            failure = f"not done after {TIMEOUT_S} s"
    if not (out / f"{name}.json").exists():
        write_result(name, out, {"error": failure})
    return json.loads((out / f"{name}.json").read_text())


def main():
    """The command line."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("log", type=Path)
    parser.add_argument("--out", type=Path, required=True)
    parser.add_argument("--only", nargs="+", choices=list(PEERS), default=list(PEERS))
    parser.add_argument("--worker", choices=list(PEERS), help=argparse.SUPPRESS)
    args = parser.parse_args()
    args.out.mkdir(parents=True, exist_ok=True)
    if args.worker:
        work_safely(args.worker, args.log, args.out)
        return
    for name in args.only:
        print(name, json.dumps(spawn(name, args.log, args.out)), flush=True)


if __name__ == "__main__":
    main()
