//! The light of a time and place: sun, sky, clouds, lamps.
//!
//! Light is relative to that of the noon without this condition. Sources: the sun's position by
//! Cooper (1969); the mass of air before it by Kasten and Young (1989); the sky's light in twilight
//! falls by a factor of 2.3 for each degree of the sun, as in tables of illuminance (Bond and
//! Henderson 1963); an overcast sky is three times as bright at the zenith as at the horizon (CIE).

use openbench_scene::Sun;
use serde::{Deserialize, Serialize};

use crate::render::{Illumination, Lamp};

/// Optical depth of clear air overhead in red, green and blue light: molecules and some haze.
const AIR: [f64; 3] = [0.15, 0.20, 0.32];
/// Factors on the light of a scene's sun and sky, whose noon has less contrast than a real one:
/// under a clear, high sun the sky gives a fifth of the light.
const SUN: f64 = 1.35;
const SKY: f64 = 0.6;
/// Light of the sky at sunset, relative to that of a high sun.
const SUNSET: f64 = 0.012;
/// Decimal logarithm by which the sky's light falls for each degree below the horizon.
const TWILIGHT_PER_DEGREE: f64 = 0.37;
/// Light of a town's sky at night: 0.3 lx of 100,000.
const NIGHT: f64 = 3e-6;
/// Light under clouds, relative to that of a high sun alone.
const UNDER_CLOUDS: f64 = 0.22;
/// Tints of the sky's light by day, in twilight, then at the horizon, and at night.
const DAY_TINT: [f64; 3] = [0.93, 1.0, 1.12];
const TWILIGHT_TINT: [f64; 3] = [0.78, 0.95, 1.30];
const HORIZON_TINT: [f64; 3] = [1.5, 1.05, 0.70];
const NIGHT_TINT: [f64; 3] = [1.25, 1.0, 0.75];
/// A street lamp gives 20 lx on the ground 5 m below: 500 lx at a metre, of 100,000.
const STREET_LAMP: [f32; 3] = [6.0e-3, 4.6e-3, 2.8e-3];
/// A lamp beside a door.
const DOOR_LAMP: [f32; 3] = [5.0e-4, 4.0e-4, 2.6e-4];
/// The robot's own light, of 250 candela.
const HEADLIGHT: [f32; 3] = [2.4e-3, 2.5e-3, 2.6e-3];
/// Light from the glass of a lamp.
const LAMP_GLASS: [f32; 3] = [0.10, 0.08, 0.05];
/// Light from a lit room.
const WINDOW: [f32; 3] = [5.0e-4, 3.6e-4, 2.0e-4];
/// Share of the windows that are lit while lamps shine.
const LIT_WINDOWS: f32 = 0.3;

/// The light of a run.
///
/// ```
/// use openbench_sim::Daylight;
///
/// // Midsummer noon in Vienna.
/// let noon = Daylight::at(48.2, 172, 12.0);
/// assert!((noon.sun_elevation_deg - 65.2).abs() < 0.5);
/// assert!((noon.sun_azimuth_deg - 180.0).abs() < 0.5);
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Daylight {
    /// Day of the year, from 1.
    pub day: u32,
    /// Hour by the sun, 0 to 24; it is highest at 12.
    pub solar_hour: f64,
    /// Height of the sun above the horizon, degrees.
    pub sun_elevation_deg: f64,
    /// Direction of the sun, degrees from north to the east.
    pub sun_azimuth_deg: f64,
    /// Share of the sky that clouds cover.
    pub clouds: f64,
    /// Whether lamps shine, windows are lit, and the robot has its light on.
    pub lamps: bool,
}

impl Daylight {
    /// The sun at a latitude in degrees, on a day of the year, at an hour by the sun, in a clear
    /// sky.
    pub fn at(latitude_deg: f64, day: u32, solar_hour: f64) -> Self {
        let year = std::f64::consts::TAU * (284.0 + f64::from(day)) / 365.0;
        let declination = (23.45 * libm::sin(year)).to_radians();
        let (latitude, hour) = (
            latitude_deg.to_radians(),
            (15.0 * (solar_hour - 12.0)).to_radians(),
        );
        let (sin_l, cos_l) = (libm::sin(latitude), libm::cos(latitude));
        let (sin_d, cos_d) = (libm::sin(declination), libm::cos(declination));
        let height = sin_l * sin_d + cos_l * cos_d * libm::cos(hour);
        let east = -cos_d * libm::sin(hour);
        let north = cos_l * sin_d - sin_l * cos_d * libm::cos(hour);
        Self {
            day,
            solar_hour,
            sun_elevation_deg: libm::asin(height.clamp(-1.0, 1.0)).to_degrees(),
            sun_azimuth_deg: libm::atan2(east, north).to_degrees().rem_euclid(360.0),
            clouds: 0.0,
            lamps: false,
        }
    }

    /// The light on a scene whose own light is `noon`, with lamps on these places.
    pub(crate) fn illumination(&self, noon: &Sun, places: &LampPlaces) -> Illumination {
        let mut light = Illumination::of(noon);
        let clear = 1.0 - self.clouds;
        let direct = self.direct();
        light.towards_sun = self.towards_sun();
        light.sun = direct.map(|share| (SUN * f64::from(noon.diffuse) * clear * share) as f32);
        // Shadows of a sun behind clouds cannot be seen.
        light.shadows = light.sun[0] > 0.02 * f64::from(noon.diffuse) as f32;
        let ambient = f64::from(noon.ambient);
        let from_sky = SKY * ambient;
        let (tint, level) = (self.tint(), self.clear_sky());
        let clouds = self.clouds * self.clouded_sky();
        for channel in 0..3 {
            let night = NIGHT * NIGHT_TINT[channel];
            let sky = from_sky * clear * level * tint[channel] + ambient * clouds + night;
            light.ambient[channel] = sky as f32;
            let overcast = clouds * ambient;
            let root = |clear_root: f32, tint: f64, share: f64, night: f64| {
                let full = f64::from(clear_root) / 255.0;
                let blue = clear * level * full * full * self.in_twilight(tint);
                (255.0 * (blue + share * overcast + night).sqrt()) as f32
            };
            // The mean over the sky is that of the light on the ground.
            let [low, high] = [HORIZON_TINT[channel], TWILIGHT_TINT[channel]];
            light.horizon[channel] = root(light.horizon[channel], low, 3.0 / 7.0, night);
            light.zenith[channel] = root(light.zenith[channel], high, 9.0 / 7.0, 0.4 * night);
        }
        self.add_glow(&mut light, clear * level);
        if self.lamps {
            light.lamps = places.lamps();
            light.lamp_glass = LAMP_GLASS;
            light.lit_windows = LIT_WINDOWS;
            light.window = WINDOW;
        }
        light
    }

    fn towards_sun(&self) -> [f32; 3] {
        let (height, azimuth) = (
            self.sun_elevation_deg.to_radians(),
            self.sun_azimuth_deg.to_radians(),
        );
        let level = libm::cos(height);
        let (east, north) = (level * libm::sin(azimuth), level * libm::cos(azimuth));
        [east, north, libm::sin(height)].map(|c| c as f32)
    }

    /// Light of the sun relative to that from overhead, by channel.
    fn direct(&self) -> [f64; 3] {
        let height = self.sun_elevation_deg;
        if height <= 0.0 {
            return [0.0; 3];
        }
        let curved = 0.505_72 * libm::pow(height + 6.079_95, -1.636_4);
        let mass = 1.0 / (libm::sin(height.to_radians()) + curved);
        AIR.map(|depth| libm::exp(-depth * (mass - 1.0)))
    }

    /// Light of a clear sky relative to that with a high sun.
    fn clear_sky(&self) -> f64 {
        let height = self.sun_elevation_deg;
        if height >= 0.0 {
            SUNSET + (1.0 - SUNSET) * libm::sin(height.to_radians()).sqrt()
        } else {
            SUNSET * libm::pow(10.0, TWILIGHT_PER_DEGREE * height)
        }
    }

    /// Light under clouds relative to that of a clear sky with a high sun.
    fn clouded_sky(&self) -> f64 {
        let height = self.sun_elevation_deg;
        if height >= 0.0 {
            let sine = libm::sin(height.to_radians());
            UNDER_CLOUDS / 0.45 * (SUNSET + (1.0 - SUNSET) * sine)
        } else {
            0.5 * self.clear_sky()
        }
    }

    /// How far the sky's colours are those of twilight, 0 to 1.
    fn lowness(&self) -> f64 {
        (1.0 - self.sun_elevation_deg / 10.0).clamp(0.0, 1.0)
    }

    fn tint(&self) -> [f64; 3] {
        let low = self.lowness();
        std::array::from_fn(|c| DAY_TINT[c] + low * (TWILIGHT_TINT[c] - DAY_TINT[c]))
    }

    /// A factor on the sky's light that is reached as the sun sets.
    fn in_twilight(&self, tint: f64) -> f64 {
        1.0 + self.lowness() * (tint - 1.0)
    }

    /// The bright sky around a low sun: orange; around a high one: white.
    fn add_glow(&self, light: &mut Illumination, level: f64) {
        let (low, root) = (self.lowness(), level.sqrt());
        let (white, orange) = ([40.0, 36.0, 28.0], [190.0, 90.0, 10.0]);
        for channel in 0..3 {
            let color = white[channel] + low * (orange[channel] - white[channel]);
            light.glow[channel] = (root * color) as f32;
        }
    }
}

/// Where lamps are.
#[derive(Debug, Clone, PartialEq, Default)]
pub(crate) struct LampPlaces {
    /// Middles of the glass of street lamps, metres in `map`.
    pub(crate) street: Vec<[f32; 3]>,
    /// The same of lamps at doors.
    pub(crate) door: Vec<[f32; 3]>,
}

impl LampPlaces {
    fn lamps(&self) -> Vec<Lamp> {
        let lamp = |strength: [f32; 3], edge: f32| {
            move |at: &[f32; 3]| Lamp {
                at: *at,
                axis: [0.0, 0.0, -1.0],
                strength,
                edge,
                sharpness: 2.0,
            }
        };
        // Street lamps light the ground evenly, and nothing above them.
        let street = self.street.iter().map(lamp(STREET_LAMP, 0.05));
        let door = self.door.iter().map(lamp(DOOR_LAMP, -0.6));
        street.chain(door).collect()
    }
}

/// The robot's own light at a place, shining along an axis.
pub(crate) fn headlight(at: [f32; 3], axis: [f32; 3]) -> Lamp {
    Lamp {
        at,
        axis,
        strength: HEADLIGHT,
        // A cone of 35 degrees to each side.
        edge: 0.82,
        sharpness: 6.0,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn light(day: u32, hour: f64) -> Illumination {
        let noon = Sun::default();
        Daylight::at(48.2, day, hour).illumination(&noon, &LampPlaces::default())
    }

    #[test]
    fn the_sun_rises_in_the_east_and_sets_in_the_west() {
        let morning = Daylight::at(48.2, 80, 7.0);
        let evening = Daylight::at(48.2, 80, 17.0);
        assert!(
            (80.0..120.0).contains(&morning.sun_azimuth_deg),
            "{morning:?}"
        );
        assert!(
            (240.0..280.0).contains(&evening.sun_azimuth_deg),
            "{evening:?}"
        );
        // In the south the noon's sun is in the north.
        let south = Daylight::at(-34.0, 172, 12.0).sun_azimuth_deg;
        assert!(!(1.0..=359.0).contains(&south), "{south}");
        assert!(Daylight::at(48.2, 172, 0.0).sun_elevation_deg < -15.0);
    }

    #[test]
    fn light_falls_from_noon_to_night_by_five_orders_of_magnitude() {
        let [noon, evening, dusk, night] =
            [12.0, 18.5, 20.3, 0.0].map(|hour| light(172, hour).ambient[1]);
        assert!(
            noon > evening && evening > dusk && dusk > night,
            "{evening} {dusk}"
        );
        assert!(noon / night > 1e4 && night > 0.0);
        let evening = light(172, 19.0).sun;
        assert!(evening[0] > evening[2], "a low sun is red: {evening:?}");
        assert_eq!(light(172, 0.0).sun, [0.0; 3]);
    }

    #[test]
    fn clouds_take_the_sun_and_its_shadows() {
        let clouded = Daylight {
            clouds: 1.0,
            ..Daylight::at(48.2, 172, 12.0)
        };
        let light = clouded.illumination(&Sun::default(), &LampPlaces::default());
        assert!(!light.shadows && light.sun == [0.0; 3]);
        assert!(light.zenith[1] > light.horizon[1]);
    }

    #[test]
    fn lamps_shine_when_they_are_on() {
        let places = LampPlaces {
            street: vec![[1.0, 2.0, 5.0]],
            door: vec![[3.0, 2.0, 2.5]],
        };
        let night = Daylight {
            lamps: true,
            ..Daylight::at(48.2, 172, 0.0)
        };
        let lamps = night.illumination(&Sun::default(), &places).lamps;
        assert_eq!(lamps.len(), 2);
        assert!(lamps[0].strength[0] > lamps[1].strength[0]);
    }
}
