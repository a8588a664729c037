//! Writes the meshes of lab 2, `scenes/labs/meshes/*.ply.gz`: `cargo run --release -p sahl --example make_lab_meshes`.
//!
//! The files are committed, so nobody has to run this; it shows where they come from.
#![expect(clippy::print_stdout, reason = "an example shows what it found")]

mod shapes;

use std::io::Write;
use std::path::Path;

use flate2::{Compression, write::GzEncoder};
use shapes::Mesh;

fn main() -> std::io::Result<()> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../scenes/labs/meshes");
    std::fs::create_dir_all(&folder)?;
    write(&folder.join("bumpy-sphere.ply.gz"), &shapes::bumpy_sphere(6))?;
    write(&folder.join("stadium.ply.gz"), &shapes::stadium())
}

/// Writes a binary PLY file, compressed.
fn write(path: &Path, mesh: &Mesh) -> std::io::Result<()> {
    let mut bytes = format!(
        "ply\nformat binary_little_endian 1.0\nelement vertex {}\nproperty float x\nproperty float y\n\
         property float z\nelement face {}\nproperty list uchar uint vertex_indices\nend_header\n",
        mesh.positions.len(),
        mesh.indices.len()
    )
    .into_bytes();
    for p in &mesh.positions {
        bytes.extend([p.x, p.y, p.z].into_iter().flat_map(f32::to_le_bytes));
    }
    for triangle in &mesh.indices {
        bytes.push(3);
        bytes.extend(triangle.iter().flat_map(|vertex| vertex.to_le_bytes()));
    }
    let mut encoder = GzEncoder::new(Vec::new(), Compression::best());
    encoder.write_all(&bytes)?;
    let compressed = encoder.finish()?;
    println!("{}: {} triangles, {} bytes", path.display(), mesh.indices.len(), compressed.len());
    std::fs::write(path, compressed)
}
