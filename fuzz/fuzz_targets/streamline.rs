//! Any bytes read as a model file give models, a curve or an error; what is read can be written, reads
//! back the same, and has a surface or an error.
#![no_main]

use fairform::streamline::Surface;
use fairform_io::streamline::{Contents, Curve, encode, encode_curve, parse_any};

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| {
    let Ok(contents) = parse_any(bytes) else { return };
    let mut out = Vec::new();
    match &contents {
        Contents::Surface(models) => encode(models, &mut out),
        Contents::Curve(curve) => encode_curve(curve, &mut out),
        _ => return,
    }
    .expect("what we read, we write");
    assert_eq!(parse_any(&out).as_ref(), Ok(&contents));
    match contents {
        Contents::Surface(models) => {
            for patch in models.patches {
                let mut model = patch.model;
                model.depth = model.depth.min(3);
                let Ok(surface) = Surface::new(model) else { continue };
                assert!(
                    surface.tangents().values().iter().all(|t| (t.length() - 1.0).abs() < 1e-9)
                );
            }
        }
        Contents::Curve(Curve::Subdivided(mut curve)) => {
            curve.depth = curve.depth.min(8);
            let _ = curve.refine();
        }
        _ => {}
    }
});
