//! What is in a mesh file? Prints, for each file named, its counts, face sizes and the reader's
//! notes, or what is wrong with it.

use std::collections::BTreeMap;
use std::path::Path;

fn main() {
    for name in std::env::args().skip(1) {
        match fairform_io::read(Path::new(&name), None) {
            Ok(data) => {
                let mut sizes = BTreeMap::new();
                for face in data.faces.iter() {
                    *sizes.entry(face.len()).or_insert(0) += 1;
                }
                println!(
                    "{name}: {} vertices, {} faces, faces by corners {sizes:?}",
                    data.positions.len(),
                    data.faces.len()
                );
                data.notes.iter().for_each(|note| println!("  {note}"));
            }
            Err(error) => println!("{error}"),
        }
    }
}
