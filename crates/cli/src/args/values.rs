//! How values on the command line are read.

pub(super) fn key_value(text: &str) -> Result<(String, String), String> {
    let (key, value) = text
        .split_once('=')
        .ok_or_else(|| format!("`{text}` is not KEY=VALUE"))?;
    Ok((key.trim().to_owned(), value.trim().to_owned()))
}

fn numbers(text: &str, count: usize) -> Option<Vec<f64>> {
    let parsed: Option<Vec<f64>> = text
        .split(',')
        .map(|p| p.trim().parse::<f64>().ok().filter(|v| v.is_finite()))
        .collect();
    parsed.filter(|v| v.len() == count)
}

pub(super) fn lonlat(text: &str) -> Result<openbench_core::LonLat, String> {
    match numbers(text, 2).as_deref() {
        Some(&[lon, lat]) if lon.abs() <= 180.0 && lat.abs() <= 90.0 => {
            Ok(openbench_core::LonLat::new(lon, lat))
        }
        _ => Err(format!("`{text}` is not LON,LAT in degrees")),
    }
}

pub(super) fn place(text: &str) -> Result<openbench_core::MapPoint, String> {
    let numbers: Vec<f64> = text
        .split(',')
        .map_while(|word| word.trim().parse().ok())
        .collect();
    match numbers[..] {
        [x, y] if x.is_finite() && y.is_finite() => Ok(openbench_core::MapPoint::new(x, y)),
        _ => Err(format!("`{text}` should be two numbers, such as 12.5,-3")),
    }
}

pub(super) fn pose(text: &str) -> Result<openbench_core::Pose2, String> {
    match numbers(text, 3).as_deref() {
        Some(&[x, y, yaw]) => Ok(openbench_core::Pose2::new(x, y, yaw.to_radians())),
        _ => Err(format!("`{text}` is not X,Y,YAW")),
    }
}

pub(super) fn pair(text: &str) -> Result<(f64, f64), String> {
    let numbers: Vec<f64> = text
        .split(',')
        .map_while(|word| word.trim().parse().ok())
        .collect();
    match numbers[..] {
        [a, b] if a.is_finite() && b.is_finite() && a >= 0.0 && b >= 0.0 => Ok((a, b)),
        _ => Err(format!(
            "`{text}` should be two numbers not below 0, such as 30,0.5"
        )),
    }
}

pub(super) fn window(text: &str) -> Result<openbench_osm::Window, String> {
    let edges = numbers(text, 4).ok_or_else(|| format!("`{text}` is not WEST,SOUTH,EAST,NORTH"))?;
    openbench_osm::Window::new(edges[0], edges[1], edges[2], edges[3]).map_err(|e| e.to_string())
}

pub(super) fn metres(text: &str) -> Result<f64, String> {
    let metres = text
        .parse()
        .ok()
        .filter(|metres: &f64| *metres > 0.0 && metres.is_finite());
    metres.ok_or_else(|| format!("`{text}` is not a length in metres"))
}

pub(super) fn radius(text: &str) -> Result<f64, String> {
    let metres = text
        .parse::<f64>()
        .ok()
        .filter(|m| (1.0..=20_000.0).contains(m));
    metres.ok_or_else(|| format!("`{text}` is no distance; give metres, 1 to 20000"))
}

pub(super) fn kilometres(text: &str) -> Result<f64, String> {
    let kilometres = text
        .parse()
        .ok()
        .filter(|kilometres| (0.001..=1000.0).contains(kilometres));
    kilometres.ok_or_else(|| format!("`{text}` should be kilometres, from 0.001 to 1000"))
}

pub(super) fn far(text: &str) -> Result<f64, String> {
    let kilometres = text
        .parse()
        .ok()
        .filter(|kilometres: &f64| (0.0..=10_000.0).contains(kilometres));
    kilometres.ok_or_else(|| format!("`{text}` should be kilometres, from 0 to 10000"))
}

pub(super) fn minutes(text: &str) -> Result<f64, String> {
    let minutes = text
        .parse()
        .ok()
        .filter(|minutes| (0.05..=600.0).contains(minutes));
    minutes.ok_or_else(|| format!("`{text}` should be minutes, from 0.05 to 600"))
}

pub(super) fn share(text: &str) -> Result<f64, String> {
    let share = text.parse::<f64>().ok().filter(|s| (0.0..=1.0).contains(s));
    share.ok_or_else(|| format!("`{text}` is no share; give a number from 0 to 1"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn places_and_settings_are_read() {
        assert_eq!(
            lonlat("7.4,-43.7").unwrap(),
            openbench_core::LonLat::new(7.4, -43.7)
        );
        assert!(lonlat("7.4").is_err() && lonlat("7.4,91").is_err() && lonlat("a,b").is_err());
        assert_eq!(key_value("a=b=c").unwrap(), ("a".into(), "b=c".into()));
        assert!(key_value("a").is_err());
    }
}
