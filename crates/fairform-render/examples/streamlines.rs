//! Pictures of a streamline model: the surface, its tangents on the Gaussian sphere, curvature combs.
//!
//! `cargo run --release -p fairform-render --example streamlines FOLDER`

use std::path::Path;

use fairform::Vec3;
use fairform::streamline::{Grid, InitialCurve, Model, Surface};
use fairform_render::{
    Directions, ModelView, Options, Panel, Part, Show, SphereView, View, render,
};

/// The bonnet of something that does not exist: six streamlines with nine tangents each.
fn model(depth: u32) -> Model {
    let t = [-1.0, -0.6, -0.2, 0.2, 0.6, 1.0];
    let row = |t: f64| {
        (0..9).map(move |i| {
            let u = f64::from(i) / 8.0;
            let pitch = 0.85 * (1.0 - 0.25 * t * t) * libm::cos(3.3 * u) - 0.10 * t * t;
            let yaw = t * (0.55 * (1.0 - u) * (1.0 - u) - 0.50 * u * u);
            let level = libm::cos(pitch);
            Vec3::new(level * libm::cos(yaw), level * libm::sin(yaw), libm::sin(pitch))
        })
    };
    let lengths = t.map(|t| 6.0 - 0.9 * t * t);
    let points = vec![
        Vec3::new(0.5, -1.7, -0.1),
        Vec3::new(-0.1, -1.5, 0.35),
        Vec3::new(-0.3, 0.0, 0.55),
        Vec3::new(-0.1, 1.5, 0.35),
        Vec3::new(0.5, 1.7, -0.1),
    ];
    let initial =
        InitialCurve::Bspline { points, weights: None, degree: 3, knots: None, t0: -1.0, t1: 1.0 };
    let tangents = Grid::from_rows(t.map(row)).expect("rows of one length");
    Model { depth, ..Model::new(tangents, &lengths, t.to_vec(), initial) }
}

fn save(place: &Path, pictures: &[(Vec<Part>, &str)], view: &str, size: (u32, u32)) {
    let panels: Vec<Panel> = pictures
        .iter()
        .map(|(parts, title)| Panel {
            bodies: parts.iter().map(Part::body).collect(),
            title: (!title.is_empty()).then(|| (*title).into()),
        })
        .collect();
    let view: View = view.parse().expect("a view");
    let options = Options { ground: !place.ends_with("spheres.png"), ..Options::default() };
    let picture = render(&panels, &view, size, &options).expect("a picture");
    std::fs::write(place, picture.to_png()).expect("a file");
}

fn main() {
    let folder = std::env::args().nth(1).unwrap_or_else(|| ".".into());
    let place = |name: &str| Path::new(&folder).join(name);
    let surface = |depth| Surface::new(model(depth)).expect("a surface");

    let view = ModelView::default();
    save(&place("model.png"), &[(view.parts(&surface(3)), "")], "35,25,z", (1200, 900));
    let depths = [0, 1, 2, 3];
    let titles = ["depth 0", "depth 1", "depth 2", "depth 3"];
    let panels: Vec<_> = depths.iter().map(|&d| view.parts(&surface(d))).zip(titles).collect();
    save(&place("depths.png"), &panels, "35,25,z", (1600, 1200));
    let combs = ModelView {
        show: vec![Show::Surface, Show::Streamlines, Show::Combs],
        ..ModelView::default()
    };
    save(&place("combs.png"), &[(combs.parts(&surface(4)), "")], "35,25,z", (1200, 900));
    let all = ModelView { show: Show::ALL.to_vec(), ..ModelView::default() };
    save(&place("all.png"), &[(all.parts(&surface(2)), "")], "35,25,z", (1200, 900));

    let sphere =
        SphereView { up: "iso,z".parse::<View>().expect("a view").up, ..Default::default() };
    let rows = Directions::rows(&model(4)).expect("rows");
    save(&place("sphere.png"), &[(sphere.parts(&rows), "")], "60,20,z", (900, 900));
    let one = &rows[2..3];
    let beads = SphereView { beads: true, ..sphere };
    let few = Directions::rows(&model(2)).expect("rows");
    let panels = [(sphere.parts(one), "one streamline"), (beads.parts(&few[..1]), "another")];
    save(&place("spheres.png"), &panels, "20,10,z", (1600, 900));
}
