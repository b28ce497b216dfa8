//! A camera with faults, or in a light other than noon's.
//!
//! What it does depends on the seed and on simulated time, and not on which images are asked for:
//! its noise is hashed from both, and its exposure is measured ten times a second on a small view.

use std::collections::VecDeque;

use nalgebra::Vector3;
use openbench_core::{CameraIntrinsics, Pose3, SimTime};
use openbench_scene::Movers;

use crate::daylight::headlight;
use crate::exposure::LightMeter;
use crate::optics::{CameraErrors, Exposure, LensBuild};
use crate::render::{
    Development, Illumination, Lamp, Lens, LightPlanes, Moment, Movement, Renderer, Shot, Streaks,
    develop, rain, smear,
};

/// Range of the camera, metres.
const RANGE_M: f32 = 200.0;
/// Time between two measurements of the light, nanoseconds.
const METERING_NS: u64 = 100_000_000;
/// Factor between the sides of an image and of the view on which light is measured.
const SMALL_VIEW_FACTOR: u32 = 16;
/// Poses that are this old are forgotten, nanoseconds. Rows are read for 50 ms at most, and
/// exposed for as long before that.
const PATH_NS: u64 = 100_000_000;
/// Time over which the movement of an image is measured, nanoseconds.
const MOVEMENT_NS: u64 = 10_000_000;
/// Poses of an image from its first row to its last.
const MOMENTS: u64 = 8;
/// Largest exposures relative to noon's, in powers of two: as without this camera, and in the dark.
const DAY_STOPS: f64 = 2.0;
const NIGHT_STOPS: f64 = 10.0;
/// Streaks in an image in rain of 1 mm/h.
const STREAKS_AT_1_MM_H: f64 = 120.0;
/// Streaks are drawn as if a shutter were open for at least as long, seconds.
const SHORTEST_STREAK_S: f64 = 0.004;
/// Height of the robot's light above its camera, metres.
const HEADLIGHT_M: f64 = 0.04;

/// A camera with faults, or in a light other than noon's.
pub(crate) struct RealCamera {
    errors: CameraErrors,
    build: LensBuild,
    lens: Lens,
    small: Lens,
    light: Illumination,
    /// Rate of the rain, mm/h.
    rain_mm_h: f64,
    /// Whether the robot has its light on.
    headlight: bool,
    /// Poses of the camera in the last [`PATH_NS`], the latest one last.
    path: VecDeque<(SimTime, Pose3)>,
    meter: Option<LightMeter>,
    metered: Option<SimTime>,
    seed: u64,
}

impl RealCamera {
    pub(crate) fn new(
        optics: &CameraIntrinsics,
        errors: CameraErrors,
        build: LensBuild,
        light: Illumination,
        rain_mm_h: f64,
        seed: u64,
    ) -> Self {
        Self {
            lens: Lens::new(optics, build.focal, build.distortion),
            small: Lens::smaller(optics, SMALL_VIEW_FACTOR),
            errors,
            build,
            headlight: light.lamp_glass[0] > 0.0,
            light,
            rain_mm_h,
            path: VecDeque::new(),
            meter: None,
            metered: None,
            seed,
        }
    }

    /// Notes the camera's pose at an instant.
    pub(crate) fn pass(&mut self, time: SimTime, pose: Pose3) {
        let known = |last: &&mut (SimTime, Pose3)| last.0 == time;
        if let Some(last) = self.path.back_mut().filter(known) {
            last.1 = pose;
            return;
        }
        self.path.push_back((time, pose));
        while self.path.len() > 2 && self.path[1].0.0 + PATH_NS < time.0 {
            self.path.pop_front();
        }
    }

    /// Measures the light if it is time for it.
    pub(crate) fn measure(&mut self, renderer: &Renderer, movers: &Movers, time: SimTime) {
        let due = |last: SimTime| time.0 - last.0 >= METERING_NS;
        if !self.metered.is_none_or(due) {
            return;
        }
        let moments = [self.moment(time.0)];
        let shot = Shot {
            lens: &self.small,
            moments: &moments,
            light: &self.light,
            lamps: &self.light.lamps_near(&moments[0].pose),
            range: RANGE_M,
        };
        let planes = renderer.photograph(&shot, movers);
        let most = if self.light.sun[0] < 0.1 {
            NIGHT_STOPS
        } else {
            DAY_STOPS
        };
        let wanted = LightMeter::settled(most, |factor| planes.mean_grey(factor));
        let seconds = self
            .metered
            .map_or(0.0, |last| (time.0 - last.0) as f64 * 1e-9);
        self.meter = Some(match self.meter {
            None => wanted,
            Some(meter) => meter.towards(wanted, seconds, self.errors.exposure_lag_s),
        });
        self.metered = Some(time);
    }

    /// The bytes of an image that ends at `time`.
    pub(crate) fn expose(&self, renderer: &Renderer, movers: &Movers, time: SimTime) -> Vec<u8> {
        let factor = self.meter.map_or(1.0, |meter| meter.factor());
        let exposure = self.errors.exposure(factor);
        let moments = self.moments(time, exposure);
        let shot = Shot {
            lens: &self.lens,
            moments: &moments,
            light: &self.light,
            lamps: &self.lamps(&moments[0].pose),
            range: RANGE_M,
        };
        let mut planes = renderer.photograph(&shot, movers);
        self.rain(&mut planes, time, exposure);
        smear(&mut planes, &self.build.drops);
        develop(
            &planes,
            Development {
                lens: &self.lens,
                movement: self.movement(time, exposure),
                factor: factor as f32,
                shot: self.errors.shot_variance(exposure.gain) as f32,
                read: self.errors.read_variance(exposure.gain) as f32,
                vignetting: self.errors.vignetting as f32,
                key: key(self.seed, time),
            },
        )
    }

    fn rain(&self, planes: &mut LightPlanes, time: SimTime, exposure: Exposure) {
        if self.rain_mm_h <= 0.0 {
            return;
        }
        let streaks = Streaks {
            // The number of drops in the air grows with a power of the rate (Marshall and Palmer
            // 1948).
            count: (STREAKS_AT_1_MM_H * libm::pow(self.rain_mm_h, 0.6)) as u32,
            seconds: exposure.seconds.max(SHORTEST_STREAK_S) as f32,
            focal_length: self.lens.focal_length,
            light: self.light.ambient,
            key: key(self.seed, time),
        };
        rain(planes, streaks);
    }

    fn lamps(&self, pose: &Pose3) -> Vec<Lamp> {
        let mut lamps = self.light.lamps_near(pose);
        if self.headlight {
            let above = pose * Pose3::translation(0.0, 0.0, HEADLIGHT_M);
            let axis = above.rotation * Vector3::x();
            let single = |v: Vector3<f64>| [v.x as f32, v.y as f32, v.z as f32];
            lamps.insert(0, headlight(single(above.translation.vector), single(axis)));
        }
        lamps
    }

    /// Where the camera is when it reads its rows, each in the middle of its exposure.
    fn moments(&self, time: SimTime, exposure: Exposure) -> Vec<Moment> {
        let readout = self.errors.readout_ms * 1e6;
        let last = time.0.saturating_sub((0.5e9 * exposure.seconds) as u64);
        let instant =
            |i: u64| last.saturating_sub((readout * (1.0 - i as f64 / MOMENTS as f64)) as u64);
        let moment = |at: u64| Moment {
            lag: -((time.0 - at) as f64 * 1e-9) as f32,
            ..self.moment(at)
        };
        (0..=MOMENTS).map(instant).map(moment).collect()
    }

    fn moment(&self, nanoseconds: u64) -> Moment {
        Moment {
            pose: self.pose_at(nanoseconds),
            lag: 0.0,
        }
    }

    /// The camera's pose at an instant, between those that were noted.
    fn pose_at(&self, nanoseconds: u64) -> Pose3 {
        let after = self.path.partition_point(|(time, _)| time.0 <= nanoseconds);
        let Some((end, there)) = self.path.get(after) else {
            return self.path.back().map_or(Pose3::identity(), |last| last.1);
        };
        let Some((begin, here)) = after.checked_sub(1).map(|before| &self.path[before]) else {
            return *there;
        };
        let share = (nanoseconds - begin.0) as f64 / (end.0 - begin.0) as f64;
        let shift = there.translation.vector - here.translation.vector;
        Pose3::from_parts(
            (here.translation.vector + share * shift).into(),
            // Poses are 2.5 ms apart: the blend of their quaternions is a rotation at even speed.
            here.rotation.nlerp(&there.rotation, share),
        )
    }

    /// Movement while the shutter is open, at the speed of the last milliseconds.
    fn movement(&self, time: SimTime, exposure: Exposure) -> Movement {
        let since = time.0.saturating_sub(MOVEMENT_NS);
        let seconds = (time.0 - since) as f64 * 1e-9;
        if seconds <= 0.0 {
            return Movement::default();
        }
        let relative = self.pose_at(since).inverse() * self.pose_at(time.0);
        let share = exposure.seconds / seconds;
        // Of a small rotation, the imaginary part of the quaternion is half the rotation vector.
        let turn = relative.rotation.imag() * (2.0 * relative.rotation.w.signum() * share);
        let shift = relative.translation.vector * share;
        Movement {
            turn: turn.cast::<f32>().into(),
            shift: shift.cast::<f32>().into(),
        }
    }
}

/// Random numbers for an image of a seed.
fn key(seed: u64, time: SimTime) -> [u32; 2] {
    // Odd multipliers spread neighbouring seeds and times over all bits, as in SplitMix64.
    let mut bits = seed.wrapping_mul(0x9e37_79b9_7f4a_7c15) ^ time.0;
    bits = (bits ^ bits >> 30).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    bits = (bits ^ bits >> 27).wrapping_mul(0x94d0_49bb_1331_11eb);
    bits ^= bits >> 31;
    [bits as u32, (bits >> 32) as u32]
}
