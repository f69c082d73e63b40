//! Keys as flash keeps them.

use cohold_protocol::key::{Key, Role};

#[test]
fn an_image_leads_back_to_its_key_and_to_no_other() {
    let key = Key::new(core::array::from_fn(|at| at as u8));
    for (role, other, mark) in [
        (Role::Peers, Role::Operator, b"haptpeer\0\0\0\0\0\0\0\0"),
        (Role::Operator, Role::Peers, b"haptoper\0\0\0\0\0\0\0\0"),
    ] {
        let image = key.image(role);
        assert_eq!(image[..16], *mark);
        assert_eq!(Key::from_image(&image, role), Some(key.clone()));
        assert_eq!(Key::from_image(&image, other), None, "a key is for one thing");
        let mut renamed = image;
        renamed[..16].copy_from_slice(&key.image(other)[..16]);
        assert_eq!(Key::from_image(&renamed, other), None, "whatever its image is called");
        for at in 0..Key::IMAGE {
            let mut broken = image;
            broken[at] ^= 0x40;
            assert_eq!(Key::from_image(&broken, role), None, "byte {at}");
        }
        assert_eq!(Key::from_image(&[0xFF; 64], role), None);
        assert_eq!(Key::from_image(&Key::new([0; 32]).image(role), role), None);
    }
}
