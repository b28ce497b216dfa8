//! The inertial measurement unit.
//!
//! The unit is the one in the MID-360, a TDK InvenSense ICM-40609-D (named in Livox's
//! specifications; data sheet DS-000330, revision 1.2). The model has white noise, a bias with a
//! random walk, errors of scale, saturation and a resolution of 16 bits.

use nalgebra::Vector3;
use openbench_core::{ImuSample, Pose3, SimTime};

use crate::noise::Noise;
use crate::physics::{GRAVITY, Physics};

/// Time between two samples, nanoseconds: 100 Hz.
pub(crate) const SAMPLE_NS: u64 = 10_000_000;
const SAMPLE_S: f64 = SAMPLE_NS as f64 * 1e-9;
const DEGREE: f64 = std::f64::consts::PI / 180.0;

/// Errors of three gyroscopes or three accelerometers, in rad/s or m/s².
#[derive(Debug, Clone, Copy)]
struct Errors {
    /// Standard deviation of the white noise of a sample.
    white: f64,
    /// Standard deviation of the bias at switch-on.
    bias: f64,
    /// Standard deviation of the bias's change in a second.
    walk: f64,
    /// Standard deviation of the scale.
    scale: f64,
    /// Largest value. The 16 bits have one step more on the negative side.
    range: f64,
}

/// Bandwidth of a sample's noise, √Hz: half the sampling rate, since densities in data sheets are
/// one-sided.
const BANDWIDTH: f64 = 7.071_067_811_865_475;

/// Front page of DS-000330: 4.5 mdps/√Hz, 10 mdps/K (taken over 20 K since the last calibration),
/// 0.5 % (taken as two standard deviations). The walk is not in the sheet: after ten minutes it is
/// 10 °/h, the floor of Allan plots of such parts. The range is the part's default.
const GYRO: Errors = Errors {
    white: 4.5e-3 * DEGREE * BANDWIDTH,
    bias: 10e-3 * DEGREE * 20.0,
    walk: 2e-6,
    scale: 2.5e-3,
    range: 2000.0 * DEGREE,
};

/// Likewise: 100 µg/√Hz, 0.15 mg/K, 0.5 %; a walk of 50 µg in ten minutes. A faulty MID-360 reports
/// a constant 4 g (issue 37 of Livox-SDK2): that is the end of the scale.
const ACCEL: Errors = Errors {
    white: 100e-6 * GRAVITY * BANDWIDTH,
    bias: 0.15e-3 * GRAVITY * 20.0,
    walk: 2e-5,
    scale: 2.5e-3,
    range: 4.0 * GRAVITY,
};

/// The inertial measurement unit.
#[derive(Debug)]
pub(crate) struct Imu {
    noise: Noise,
    mount: Pose3,
    gyro: Triad,
    accel: Triad,
    last_velocity: Vector3<f64>,
}

impl Imu {
    /// A unit mounted as in the robot's description.
    pub(crate) fn new(mut noise: Noise, mount: Pose3) -> Self {
        let gyro = Triad::new(GYRO, &mut noise);
        let accel = Triad::new(ACCEL, &mut noise);
        Self {
            noise,
            mount,
            gyro,
            accel,
            last_velocity: Vector3::zeros(),
        }
    }

    /// Begins a rest: the next sample notices nothing of the motion before.
    pub(crate) fn rest(&mut self) {
        self.last_velocity = Vector3::zeros();
    }

    /// The sample at `stamp`. The specific force is the mean since the last sample.
    pub(crate) fn sample(&mut self, stamp: SimTime, physics: &Physics) -> ImuSample {
        let base = physics.base_link();
        // Physics reports in `map`; the unit measures along its own axes.
        let to_sensor = (base.rotation * self.mount.rotation).inverse();
        // At the unit's own place, so that turns and tilts of the robot accelerate it.
        let velocity = physics.velocity_at(self.mount.translation.vector);
        // Specific force is acceleration less gravity: at rest, the unit measures gravity upwards.
        let acceleration = (velocity - self.last_velocity) / SAMPLE_S + Vector3::z() * GRAVITY;
        self.last_velocity = velocity;
        let gyro = self
            .gyro
            .measure(to_sensor * physics.angular_velocity(), &mut self.noise);
        let accel = self
            .accel
            .measure(to_sensor * acceleration, &mut self.noise);
        ImuSample {
            stamp,
            gyro: gyro.into(),
            accel: accel.into(),
        }
    }
}

/// Three gyroscopes or three accelerometers.
#[derive(Debug)]
struct Triad {
    errors: Errors,
    bias: Vector3<f64>,
    scale: Vector3<f64>,
}

impl Triad {
    fn new(errors: Errors, noise: &mut Noise) -> Self {
        let bias = normal3(noise) * errors.bias;
        Self {
            errors,
            bias,
            scale: normal3(noise).map(|n| 1.0 + n * errors.scale),
        }
    }

    /// The measurement of `truth`.
    fn measure(&mut self, truth: Vector3<f64>, noise: &mut Noise) -> Vector3<f64> {
        // The variance of a random walk grows with time, so its steps grow with the root of the
        // interval.
        self.bias += normal3(noise) * (self.errors.walk * SAMPLE_S.sqrt());
        let analog =
            truth.component_mul(&self.scale) + self.bias + normal3(noise) * self.errors.white;
        analog.map(|value| self.errors.digital(value))
    }
}

impl Errors {
    /// The nearest value that 16 bits can represent.
    fn digital(&self, value: f64) -> f64 {
        let step = self.range / 32768.0;
        libm::round(value / step).clamp(-32768.0, 32767.0) * step
    }
}

fn normal3(noise: &mut Noise) -> Vector3<f64> {
    Vector3::from_fn(|_, _| noise.normal())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Allan deviations of a unit at rest, mean of the three axes, for these averaging times in
    /// seconds (IEEE 952, annex C).
    fn allan_deviations(errors: Errors, seconds: usize, times: [usize; 2]) -> [f64; 2] {
        let mut noise = Noise::new(5, 1);
        let mut triad = Triad::new(errors, &mut noise);
        let samples: Vec<_> = (0..100 * seconds)
            .map(|_| triad.measure(Vector3::zeros(), &mut noise))
            .collect();
        times.map(|time| {
            let means: Vec<Vector3<f64>> = samples
                .chunks_exact(100 * time)
                .map(|c| c.iter().sum::<Vector3<f64>>() / c.len() as f64)
                .collect();
            let steps = means
                .windows(2)
                .map(|pair| (pair[1] - pair[0]).norm_squared());
            (steps.sum::<f64>() / (6 * (means.len() - 1)) as f64).sqrt()
        })
    }

    #[test]
    fn noise_falls_with_the_averaging_time_and_the_bias_walks() {
        for errors in [GYRO, ACCEL] {
            let [short, long] = allan_deviations(errors, 6000, [1, 300]);
            let digits = errors.range / 32768.0 / 12.0_f64.sqrt();
            // N / √τ with the noise of a second's hundred samples; K √(τ / 3) with the walk of a
            // second, and the remaining noise.
            let white = libm::hypot(errors.white, digits) / 10.0;
            let walk = libm::hypot(errors.walk * 10.0, white / 300.0_f64.sqrt());
            assert!((short / white - 1.0).abs() < 0.1, "{short} against {white}");
            assert!((0.6..1.6).contains(&(long / walk)), "{long} against {walk}");
        }
    }

    #[test]
    fn noise_matches_the_data_sheet() {
        // 4.5 mdps/√Hz over 50 Hz are 0.032 °/s; 100 µg/√Hz are 0.71 mg.
        assert!(
            (GYRO.white / DEGREE - 0.0318).abs() < 1e-4
                && (ACCEL.white / GRAVITY - 0.71e-3).abs() < 1e-5
        );
    }

    #[test]
    fn samples_are_whole_steps_and_saturate_at_the_range() {
        assert_eq!(ACCEL.digital(1e9), ACCEL.range * 32767.0 / 32768.0);
        assert_eq!(ACCEL.digital(-1e9), -4.0 * GRAVITY);
        let step = GYRO.range / 32768.0;
        assert_eq!(GYRO.digital(2.4 * step), 2.0 * step);
        // The data sheet has 16.4 steps for 1 °/s.
        assert!((1.0 / (step / DEGREE) - 16.4).abs() < 0.02);
    }

    #[test]
    fn units_differ_in_bias_and_scale() {
        let units: Vec<Triad> = (0..500)
            .map(|seed| Triad::new(GYRO, &mut Noise::new(seed, 1)))
            .collect();
        let deviation = |values: Vec<f64>| {
            (values.iter().map(|v| v * v).sum::<f64>() / values.len() as f64).sqrt()
        };
        let bias = deviation(units.iter().map(|u| u.bias.x).collect());
        let scale = deviation(units.iter().map(|u| u.scale.x - 1.0).collect());
        assert!((bias / GYRO.bias - 1.0).abs() < 0.1 && (scale / GYRO.scale - 1.0).abs() < 0.1);
    }
}
