//! A picture of some meshes, side by side: `picture OUT.png VIEW WORDS FILE.obj|FILE.off …`, where
//! WORDS are any of flat, wire, boundary, points, cage, unshared, dark, clear, plain, near, large
//! and small, of height, warp, bands, isolines and log (colours by number), creases, and of zebra and
//! reflection, joined by `+`.
//!
//! The reader here knows just enough to read well-formed files; `fairform-io` has the real ones.

use std::error::Error;
use std::path::Path;

use fairform::{Faces, Vec3};
use fairform_render::{
    Body, Colour, ColourMap, Dot, Line, Options, Panel, Style, Surface, Values, View, render,
};

fn main() -> Result<(), Box<dyn Error>> {
    let args: Vec<String> = std::env::args().skip(1).collect();
    let [out, view, words, files @ ..] = &args[..] else {
        return Err("usage: picture OUT.png VIEW WORDS FILE…".into());
    };
    let has = |word: &str| words.split('+').any(|w| w == word);
    let meshes: Vec<(Vec<Vec3>, Faces)> = files.iter().map(read).collect::<Result<_, _>>()?;
    let style = Style {
        smooth: !has("flat"),
        fill: (!has("cage")).then_some(Colour::PORCELAIN),
        wireframe: (has("wire") || has("cage")).then(Line::default),
        boundary: has("boundary").then_some(Line { colour: Colour::RED, width: 4.0 }),
        points: has("points").then(Dot::default),
        surface: match () {
            () if has("zebra") => Surface::ZEBRA,
            () if has("reflection") => Surface::REFLECTION,
            () => Surface::Plain,
        },
        ..Style::default()
    };
    let bands = has("bands").then_some(10);
    let isolines = has("isolines").then(Line::default);
    let heights: Vec<Vec<f64>> =
        meshes.iter().map(|(p, _)| p.iter().map(|p| p.y).collect()).collect();
    let warps: Vec<Vec<f64>> =
        meshes.iter().map(|(p, faces)| faces.iter().map(|face| warp(p, face)).collect()).collect();
    let creases: Vec<Vec<([u32; 2], Line)>> = meshes
        .iter()
        .map(|(p, faces)| if has("creases") { creases(p, faces) } else { Vec::new() })
        .collect();
    let panels: Vec<Panel> = meshes
        .iter()
        .zip(files)
        .enumerate()
        .map(|(i, ((positions, faces), file))| Panel {
            bodies: vec![Body {
                style,
                strokes: &creases[i],
                values: match () {
                    () if has("height") => Some(Values {
                        legend: Some("height (mm)"),
                        bands,
                        isolines,
                        ..Values::per_vertex(&heights[i])
                    }),
                    () if has("warp") => Some(Values {
                        legend: Some("warp (°)"),
                        map: ColourMap::CoolWarm,
                        log: has("log"),
                        bands,
                        ..Values::per_face(&warps[i])
                    }),
                    () => None,
                },
                ..Body::new(positions, faces)
            }],
            title: Path::new(file).file_stem().map(|s| s.to_string_lossy().replace('_', " ")),
        })
        .collect();
    let options = Options {
        shared: !has("unshared"),
        shared_range: !has("unshared"),
        background: match () {
            () if has("dark") => Colour::hex(0x20_24_2a),
            () if has("clear") => Colour::TRANSPARENT,
            () => Colour::WHITE,
        },
        ground: !has("plain"),
        shadows: !has("plain"),
        ..Options::default()
    };
    let size = match () {
        () if has("large") => (2400, 1600),
        () if has("small") => (400, 300),
        () => (1200, 800),
    };
    let zoom = if has("near") { 4.0 } else { 1.0 };
    let view = View { zoom, ..view.parse()? };
    let picture = render(&panels, &view, size, &options)?;
    std::fs::write(out, picture.to_png())?;
    Ok(())
}

fn area(p: [Vec3; 3]) -> Vec3 {
    (p[1] - p[0]).cross(p[2] - p[0])
}

/// Angle in degrees between the two halves of a quad, NaN for other faces.
fn warp(p: &[Vec3], face: &[u32]) -> f64 {
    let &[a, b, c, d] = face else { return f64::NAN };
    let [a, b, c, d] = [a, b, c, d].map(|v| p[v as usize]);
    let cosine = area([a, b, c]).normalized().dot(area([a, c, d]).normalized());
    libm::acos(cosine.clamp(-1.0, 1.0)).to_degrees()
}

/// The edges where two faces meet at more than 40 degrees.
fn creases(p: &[Vec3], faces: &Faces) -> Vec<([u32; 2], Line)> {
    let mut normals = std::collections::BTreeMap::<[u32; 2], Vec<Vec3>>::new();
    for face in faces.iter() {
        let corners = [0, 1, 2].map(|i| p[face[i] as usize]);
        for i in 0..face.len() {
            let (a, b) = (face[i], face[(i + 1) % face.len()]);
            normals.entry([a.min(b), a.max(b)]).or_default().push(area(corners).normalized());
        }
    }
    let line = Line { colour: Colour::hex(0xc4_3a_2c), width: 4.0 };
    let is_sharp = |n: &[Vec3]| n.len() == 2 && n[0].dot(n[1]) < 0.766;
    normals.into_iter().filter(|(_, n)| is_sharp(n)).map(|(ends, _)| (ends, line)).collect()
}

fn read(path: &String) -> Result<(Vec<Vec3>, Faces), Box<dyn Error>> {
    let text = std::fs::read_to_string(path)?;
    let (mut positions, mut faces) = (Vec::new(), Faces::new());
    if Path::new(path).extension().is_some_and(|e| e == "off") {
        let lines = text.lines().map(|l| l.split('#').next().unwrap_or_default());
        let mut words = lines.flat_map(str::split_whitespace).filter(|w| *w != "OFF");
        let mut next = || words.next().ok_or("the file ends too early");
        let (v, f): (usize, usize) = (next()?.parse()?, next()?.parse()?);
        next()?;
        for _ in 0..v {
            positions.push([next()?.parse()?, next()?.parse()?, next()?.parse()?].into());
        }
        for _ in 0..f {
            let n = next()?.parse::<usize>()?;
            let face = (0..n).map(|_| Ok::<u32, Box<dyn Error>>(next()?.parse()?));
            faces.push(&face.collect::<Result<Vec<u32>, _>>()?);
        }
        return Ok((positions, faces));
    }
    for line in text.lines() {
        let mut words = line.split_whitespace();
        match words.next() {
            Some("v") => {
                let p: Vec<f64> = words.take(3).map(str::parse).collect::<Result<_, _>>()?;
                positions.push(Vec3::new(p[0], p[1], p[2]));
            }
            Some("f") => {
                let index = |w: &str| w.split('/').next().unwrap_or(w).parse::<u32>();
                let face: Vec<u32> = words.map(index).collect::<Result<_, _>>()?;
                faces.push(&face.iter().map(|v| v - 1).collect::<Vec<_>>());
            }
            _ => {}
        }
    }
    Ok((positions, faces))
}
