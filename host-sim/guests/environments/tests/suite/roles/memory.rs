//! Bounded memory: a client of a static world is one value of fixed size.

use cohold_environments::roles::static_scene::Download;

#[test]
fn a_client_of_a_static_world_fits_on_a_microcontroller() {
    let bytes = size_of::<Download<64>>();
    println!("Download of 64 objects {bytes} B, of 256 {} B", size_of::<Download<256>>());
    assert!(bytes <= 8 * 1024);
}
