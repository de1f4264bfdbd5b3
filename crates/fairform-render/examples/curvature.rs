//! Surfaces coloured by their exact curvature, between stripes, and in the studio:
//! `curvature FOLDER` writes some pictures there.

use std::error::Error;
use std::f64::consts::TAU;
use std::path::Path;

use fairform::{Faces, Vec3};
use fairform_render::{
    Body, Colour, ColourMap, Line, Options, Panel, Range, Surface, Values, View, render,
};

/// A surface with what is known of it at each vertex.
struct Known {
    positions: Vec<Vec3>,
    faces: Faces,
    normals: Vec<Vec3>,
    gaussian: Vec<f64>,
    mean: Vec<f64>,
    /// Of the parameter around, in radians.
    angle: Vec<f64>,
}

impl Known {
    fn body(&self) -> Body<'_> {
        Body { normals: Some(&self.normals), ..Body::new(&self.positions, &self.faces) }
    }

    fn panel<'a>(&'a self, values: Option<Values<'a>>, surface: Surface, title: &str) -> Panel<'a> {
        let mut body = Body { values, ..self.body() };
        body.style.surface = surface;
        Panel { bodies: vec![body], title: Some(title.into()) }
    }
}

fn main() -> Result<(), Box<dyn Error>> {
    let folder = std::env::args().nth(1).ok_or("usage: curvature FOLDER")?;
    let save = |name: &str, panels: &[Panel], view: &str, size, options: &Options| {
        let picture = render(panels, &view.parse::<View>()?, size, options)?;
        std::fs::write(Path::new(&folder).join(name), picture.to_png())?;
        Ok::<(), Box<dyn Error>>(())
    };
    let torus = torus(144, 72);
    let saddle = saddle(96);
    let plain = Surface::Plain;
    let options = Options::default();
    let of = |known: &Known| -> [f64; 2] {
        let low = known.gaussian.iter().copied().fold(f64::INFINITY, f64::min);
        [low, known.gaussian.iter().copied().fold(f64::NEG_INFINITY, f64::max)]
    };
    println!("curvature of the torus from {:?}, of the saddle from {:?}", of(&torus), of(&saddle));

    let gaussian = Values {
        map: ColourMap::CoolWarm,
        legend: Some("Gaussian curvature (1/mm²)"),
        ..Values::per_vertex(&torus.gaussian)
    };
    let panel = torus.panel(Some(gaussian), plain, "A torus");
    save("torus.png", &[panel], "35,35,z", (1200, 800), &options)?;

    let mean = Values { legend: Some("mean curvature (1/mm)"), ..Values::per_vertex(&torus.mean) };
    let angle = Values {
        map: ColourMap::Cyclic,
        range: Range::Between(0.0, TAU),
        legend: Some("angle (rad)"),
        ..Values::per_vertex(&torus.angle)
    };
    let line = Line { colour: Colour::INK, width: 2.0 };
    let sheet = [
        torus.panel(Some(gaussian), plain, "Gaussian\nblue where the torus is a saddle"),
        torus.panel(Some(mean), plain, "mean\nthe same everywhere along a circle"),
        torus.panel(
            Some(Values { bands: Some(10), ..gaussian }),
            plain,
            "bands\nbetween round numbers",
        ),
        torus.panel(
            Some(Values { isolines: Some(line), ..mean }),
            plain,
            "isolines\nat the numbers of the bar",
        ),
        torus.panel(Some(angle), plain, "angle\naround the circle"),
        torus.panel(
            Some(Values { range: Range::Between(0.3, 0.5), ..mean }),
            plain,
            "a given range\npoints at the bar: more beyond",
        ),
    ];
    save("sheet.png", &sheet, "35,35,z", (1600, 1100), &options)?;

    let mirrors = [
        torus.panel(None, plain, "plain"),
        torus.panel(None, Surface::ZEBRA, "zebra"),
        torus.panel(None, Surface::REFLECTION, "reflection"),
        saddle.panel(None, plain, "plain"),
        saddle.panel(None, "zebra,x,16".parse()?, "zebra,x,16"),
        saddle.panel(None, "reflection,y".parse()?, "reflection,y"),
    ];
    let own = Options { shared: false, ..options };
    save("mirrors.png", &mirrors, "35,35,z", (1600, 1000), &own)?;

    let strips = saddle.panel(Some(Values { of: &saddle.gaussian, ..gaussian }), plain, "saddle");
    let torus = torus.panel(Some(gaussian), plain, "torus");
    save("two.png", &[torus, strips], "35,35,z", (1600, 700), &own)?;
    Ok(())
}

/// A tube of radius 1 around a circle of radius 2.2.
fn torus(around: u32, across: u32) -> Known {
    let (large, small) = (2.2, 1.0);
    let index = |i: u32, j: u32| (i % around) * across + j % across;
    let faces = (0..around).flat_map(|i| {
        (0..across)
            .map(move |j| [index(i, j), index(i + 1, j), index(i + 1, j + 1), index(i, j + 1)])
    });
    let mut known = Known::new(faces.collect());
    for i in 0..around {
        for j in 0..across {
            let [u, v] = [(i, around), (j, across)].map(|(k, n)| TAU * f64::from(k) / f64::from(n));
            let out = Vec3::new(libm::cos(u), libm::sin(u), 0.0);
            let normal = libm::cos(v) * out + libm::sin(v) * Vec3::new(0.0, 0.0, 1.0);
            let radius = large + small * libm::cos(v);
            known.positions.push(large * out + small * normal);
            known.normals.push(normal);
            known.gaussian.push(libm::cos(v) / (small * radius));
            known.mean.push((large + 2.0 * small * libm::cos(v)) / (2.0 * small * radius));
            known.angle.push(u);
        }
    }
    known
}

/// The graph of $`(x^2 - y^2) / 2`$ over a square.
fn saddle(n: u32) -> Known {
    let index = |i: u32, j: u32| i * (n + 1) + j;
    let faces = (0..n).flat_map(|i| {
        (0..n).map(move |j| [index(i, j), index(i + 1, j), index(i + 1, j + 1), index(i, j + 1)])
    });
    let mut known = Known::new(faces.collect());
    for i in 0..=n {
        for j in 0..=n {
            let [x, y] = [i, j].map(|k| 2.0 * f64::from(k) / f64::from(n) - 1.0);
            let square = 1.0 + x * x + y * y;
            known.positions.push(Vec3::new(x, y, 0.5 * (x * x - y * y)));
            known.normals.push(Vec3::new(-x, y, 1.0).normalized());
            known.gaussian.push(-1.0 / (square * square));
            known.mean.push(0.5 * (y * y - x * x) / (square * square.sqrt()));
            known.angle.push(libm::atan2(y, x));
        }
    }
    known
}

impl Known {
    fn new(faces: Faces) -> Self {
        Self {
            positions: Vec::new(),
            faces,
            normals: Vec::new(),
            gaussian: Vec::new(),
            mean: Vec::new(),
            angle: Vec::new(),
        }
    }
}
