//! The end of a connection at which a policy in Python sits.

use std::fs::File;
use std::io::{BufReader, Write};
use std::os::fd::AsFd;
use std::sync::Mutex;

use numpy::{PyArray1, PyArray2, PyArray3, PyArrayMethods, ToPyArray};
use openbench_agents::remote::channel::ChannelPolicy;
use openbench_agents::remote::frame::{frame, read_frame};
use openbench_agents::remote::message::{
    Act, Begin, Errand, Hello, PROTOCOL, Picture, Reply, Report, Request, Scan,
};
use openbench_core::{Action, GiveUp, Velocity};
use pyo3::prelude::*;
use pyo3::types::{PyBytes, PyDict};
use serde_bytes::ByteBuf;

use crate::errors::ProtocolError;

/// The policy's end of a connection: the standard input and output of a child process, or channels
/// of this process.
#[pyclass(frozen)]
pub struct PolicyEnd {
    end: End,
}

enum End {
    Pipes(Mutex<Pipes>),
    Channels(Mutex<ChannelPolicy>),
}

struct Pipes {
    input: BufReader<File>,
    output: File,
}

impl PolicyEnd {
    pub fn of_channels(channels: ChannelPolicy) -> Self {
        Self {
            end: End::Channels(Mutex::new(channels)),
        }
    }

    /// Waits for the next message without the interpreter's lock.
    fn next(&self, py: Python<'_>) -> PyResult<Option<Request>> {
        py.detach(|| match &self.end {
            End::Pipes(pipes) => read_frame(&mut locked(pipes).input).map_err(protocol),
            End::Channels(channels) => Ok(locked(channels).receive()),
        })
    }

    fn say(&self, py: Python<'_>, reply: Reply) -> PyResult<()> {
        py.detach(|| match &self.end {
            End::Pipes(pipes) => {
                let bytes = frame(&reply).map_err(protocol)?;
                let output = &mut locked(pipes).output;
                Ok(output.write_all(&bytes)?)
            }
            End::Channels(channels) => {
                locked(channels).send(reply);
                Ok(())
            }
        })
    }
}

#[pymethods]
impl PolicyEnd {
    /// The end of a child process: takes over standard input and output.
    #[staticmethod]
    fn of_standard_streams() -> PyResult<Self> {
        let input = std::io::stdin().as_fd().try_clone_to_owned()?;
        let output = std::io::stdout().as_fd().try_clone_to_owned()?;
        Ok(Self {
            end: End::Pipes(Mutex::new(Pipes {
                input: BufReader::new(File::from(input)),
                output: File::from(output),
            })),
        })
    }

    /// Says who speaks, first of all.
    fn hello(&self, py: Python<'_>, program: String) -> PyResult<()> {
        let hello = Hello {
            protocol: PROTOCOL,
            program,
        };
        self.say(py, Reply::Hello(hello))
    }

    /// The next message: its name and its content; `None` when there will be no more.
    fn receive<'py>(
        &self,
        py: Python<'py>,
    ) -> PyResult<Option<(&'static str, Bound<'py, PyDict>)>> {
        let Some(request) = self.next(py)? else {
            return Ok(None);
        };
        let content = PyDict::new(py);
        let name = match request {
            Request::Begin(begin) => {
                begin_into(&content, *begin)?;
                "begin"
            }
            Request::Act(act) => {
                act_into(&content, &act)?;
                "act"
            }
            Request::Finish => "finish",
            Request::Scan(_) | Request::Image(_) => {
                return Err(ProtocolError::new_err(
                    "nobody asked for this scan or image",
                ));
            }
        };
        Ok(Some((name, content)))
    }

    /// The scan of the current observation: stamp in nanoseconds, positions, offsets in
    /// nanoseconds, reflectivities, lines.
    fn scan<'py>(&self, py: Python<'py>) -> PyResult<Option<ScanArrays<'py>>> {
        self.say(py, Reply::WantScan)?;
        match self.next(py)? {
            Some(Request::Scan(scan)) => scan.map(|scan| scan_arrays(py, &scan)).transpose(),
            _ => Err(ProtocolError::new_err("the benchmark sent no scan")),
        }
    }

    /// The image of this instant, if the camera has one: stamp in nanoseconds, pixels.
    fn image<'py>(&self, py: Python<'py>) -> PyResult<Option<ImageArray<'py>>> {
        self.say(py, Reply::WantImage)?;
        match self.next(py)? {
            Some(Request::Image(image)) => image.map(|image| image_array(py, &image)).transpose(),
            _ => Err(ProtocolError::new_err("the benchmark sent no image")),
        }
    }

    fn ready(&self, py: Python<'_>, reports: &str) -> PyResult<()> {
        let reports = reports_of(reports)?;
        self.say(py, Reply::Ready { reports })
    }

    fn refuse(&self, py: Python<'_>, give_up: &str) -> PyResult<()> {
        let give_up: GiveUp = of_json(give_up)?;
        self.say(py, Reply::Refuse(give_up))
    }

    fn drive(&self, py: Python<'_>, linear: f64, angular: f64, reports: &str) -> PyResult<()> {
        let action = Action::Drive(Velocity::new(linear, angular));
        let reports = reports_of(reports)?;
        self.say(py, Reply::Action { action, reports })
    }

    fn act(&self, py: Python<'_>, action: &str, reports: &str) -> PyResult<()> {
        let action: Action = of_json(action)?;
        let reports = reports_of(reports)?;
        self.say(py, Reply::Action { action, reports })
    }

    fn finished(&self, py: Python<'_>, map: Option<Vec<u8>>) -> PyResult<()> {
        let map = map.map(ByteBuf::from);
        self.say(py, Reply::Finished { map })
    }

    fn failed(&self, py: Python<'_>, detail: String) -> PyResult<()> {
        self.say(py, Reply::Failed { detail })
    }
}

type ScanArrays<'py> = (
    u64,
    Bound<'py, PyArray2<f32>>,
    Bound<'py, PyArray1<u32>>,
    Bound<'py, PyArray1<u8>>,
    Bound<'py, PyArray1<u8>>,
);
type ImageArray<'py> = (u64, Bound<'py, PyArray3<u8>>);

fn begin_into(content: &Bound<'_, PyDict>, begin: Begin) -> PyResult<()> {
    let py = content.py();
    content.set_item("seed", begin.seed)?;
    match begin.goal {
        Errand::Instruction(text) => content.set_item("instruction", text)?,
        Errand::Point(point) => content.set_item("point", (point.x, point.y))?,
        Errand::Image(image) => content.set_item("image", image_array(py, &image)?.1)?,
    }
    content.set_item("map", PyBytes::new(py, &begin.map))?;
    content.set_item("georeference", json(&begin.georeference)?)?;
    let start = begin.start.map(|start| (start.x, start.y, start.yaw));
    content.set_item("start", start)?;
    let covariance = begin
        .start_covariance
        .map(|rows| rows.map(Vec::from).to_vec());
    content.set_item("start_covariance", covariance)?;
    let area = begin.start_area.map(|disc| (disc.x, disc.y, disc.radius_m));
    content.set_item("start_area", area)?;
    content.set_item("robot", json(&begin.robot)?)?;
    content.set_item("time_limit", begin.time_limit_s)
}

fn act_into(content: &Bound<'_, PyDict>, act: &Act) -> PyResult<()> {
    let py = content.py();
    content.set_item("time", act.time.seconds())?;
    let imu = act.imu.iter().flat_map(|sample| {
        let ([p, q, r], [x, y, z]) = (sample.gyro, sample.accel);
        [sample.stamp.seconds(), p, q, r, x, y, z]
    });
    let imu: Vec<f64> = imu.collect();
    content.set_item("imu", imu.to_pyarray(py).reshape([act.imu.len(), 7])?)?;
    let wheels = act.wheels.iter();
    let wheels = wheels.flat_map(|sample| [sample.stamp.seconds(), sample.left, sample.right]);
    let wheels: Vec<f64> = wheels.collect();
    content.set_item(
        "wheels",
        wheels.to_pyarray(py).reshape([act.wheels.len(), 3])?,
    )?;
    content.set_item("has_scan", act.has_scan)?;
    if let Some(fix) = act.gnss {
        let fix = (
            fix.stamp.seconds(),
            fix.position,
            fix.covariance,
            fix.satellites,
        );
        content.set_item("gnss", fix)?;
    }
    Ok(())
}

fn scan_arrays<'py>(py: Python<'py>, scan: &Scan) -> PyResult<ScanArrays<'py>> {
    let (words, _) = scan.xyz.as_chunks::<4>();
    let xyz: Vec<f32> = words
        .iter()
        .map(|bytes| f32::from_le_bytes(*bytes))
        .collect();
    let (words, _) = scan.offset_ns.as_chunks::<4>();
    let offsets: Vec<u32> = words
        .iter()
        .map(|bytes| u32::from_le_bytes(*bytes))
        .collect();
    Ok((
        scan.stamp.0,
        PyArray1::from_vec(py, xyz).reshape([offsets.len(), 3])?,
        PyArray1::from_vec(py, offsets),
        scan.reflectivity.to_pyarray(py),
        scan.line.to_pyarray(py),
    ))
}

fn image_array<'py>(py: Python<'py>, image: &Picture) -> PyResult<ImageArray<'py>> {
    let shape = [image.height as usize, image.width as usize, 3];
    Ok((image.stamp.0, image.rgb.to_pyarray(py).reshape(shape)?))
}

fn json(value: &impl serde::Serialize) -> PyResult<String> {
    serde_json::to_string(value).map_err(|error| ProtocolError::new_err(error.to_string()))
}

fn of_json<T: serde::de::DeserializeOwned>(text: &str) -> PyResult<T> {
    serde_json::from_str(text).map_err(|error| ProtocolError::new_err(error.to_string()))
}

fn reports_of(text: &str) -> PyResult<Vec<Report>> {
    if text.is_empty() {
        Ok(Vec::new())
    } else {
        of_json(text)
    }
}

fn protocol(error: impl std::fmt::Display) -> PyErr {
    ProtocolError::new_err(error.to_string())
}

fn locked<T>(mutex: &Mutex<T>) -> std::sync::MutexGuard<'_, T> {
    mutex
        .lock()
        .unwrap_or_else(std::sync::PoisonError::into_inner)
}
