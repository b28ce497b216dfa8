//! Writes a drawn neighbourhood as OSM XML to standard output: `draw KIND SEED`.

use std::io::Write;

use openbench_neighbourhoods::{Kind, draw};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mut arguments = std::env::args().skip(1);
    let kind: Kind = arguments.next().unwrap_or("medium".into()).parse()?;
    let seed: u64 = arguments.next().unwrap_or("1".into()).parse()?;
    std::io::stdout().write_all(&draw(kind, seed).map.to_xml())?;
    Ok(())
}
