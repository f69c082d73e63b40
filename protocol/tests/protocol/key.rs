//! A key as flash keeps it.

use haptic_protocol::key::Key;

#[test]
fn an_image_leads_back_to_its_key_and_to_no_other() {
    let key = Key::new(core::array::from_fn(|at| at as u8));
    let image = key.image();
    assert_eq!(image[..16], *b"haptkey1\0\0\0\0\0\0\0\0");
    assert_eq!(Key::from_image(&image), Some(key));
    for at in 0..Key::IMAGE {
        let mut broken = image;
        broken[at] ^= 0x40;
        assert_eq!(Key::from_image(&broken), None, "byte {at}");
    }
    assert_eq!(Key::from_image(&[0xFF; 64]), None);
    assert_eq!(Key::from_image(&Key::new([0; 32]).image()), None);
}
