//! Writes the frames that `models/reference.json` was made from into the folder named by the first argument:
//! `cargo run -p red-bodies --example frames -- models`

use std::env;
use std::error::Error;
use std::fs;
use std::path::PathBuf;

use red_bodies::scene::Scene;

fn main() -> Result<(), Box<dyn Error>> {
    let folder = PathBuf::from(env::args().nth(1).ok_or("usage: frames FOLDER")?);
    let scene = Scene::new(160, 96);
    let mut image = vec![0.0; scene.len()];
    for (name, frame, obstacle) in [("clear", 0, false), ("obstacle", 25, true)] {
        scene.draw(frame, obstacle, &mut image)?;
        let bytes: Vec<u8> = image.iter().map(|value| (value * 255.0).round() as u8).collect();
        fs::write(folder.join(format!("frame-{name}.rgb")), bytes)?;
    }
    Ok(())
}
