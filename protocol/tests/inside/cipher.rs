//! Both ciphers give the bits of RFC 8439, and the same as each other.

use super::*;
use crate::error::Refusal;
use crate::key::{Key, NONCE_LEN};

fn bytes(hex: &str) -> Vec<u8> {
    (0..hex.len()).step_by(2).map(|at| u8::from_str_radix(&hex[at..at + 2], 16).unwrap()).collect()
}

const SUNSCREEN: &[u8] =
    b"Ladies and Gentlemen of the class of '99: If I could offer you only one tip for the future, \
                           sunscreen would be it.";

/// Section 2.8.2 of the RFC, sealed and opened, and refused with any bit of it flipped.
macro_rules! rfc {
    ($name:ident, $implementation:ident) => {
        #[test]
        fn $name() {
            let key = Key::new(std::array::from_fn(|at| 0x80 + at as u8));
            let nonce: [u8; NONCE_LEN] = bytes("070000004041424344454647").try_into().unwrap();
            let (head, cipher) = (bytes("50515253c0c1c2c3c4c5c6c7"), $implementation::Cipher::new(&key));
            let mut body = SUNSCREEN.to_vec();
            let tag = cipher.seal(nonce, &head, &mut body).unwrap();
            let wanted = concat!(
                "d31a8d34648e60db7b86afbc53ef7ec2a4aded51296e08fea9e2b5a736ee62d63dbea45e8ca9671282fafb69da92728b",
                "1a71de0a9e060b2905d6a5b67ecd3b3692ddbd7f2d778b8c9803aee328091b58fab324e4fad675945585808b4831d7bc",
                "3ff4def08e4b7a9de576d26586cec64b6116",
            );
            assert_eq!((&body[..], &tag[..]), (&bytes(wanted)[..], &bytes("1ae10b594f09e26a7e902ecbd0600691")[..]));
            let open = |head: &[u8], sealed: &[u8], tag| {
                let mut body = sealed.to_vec();
                cipher.open(nonce, head, &mut body, tag).map(|()| body)
            };
            assert_eq!(open(&head, &body, tag).unwrap(), SUNSCREEN);
            let whole = [&head[..], &body, &tag].concat();
            for bit in 0..8 * whole.len() {
                let mut forged = whole.clone();
                forged[bit / 8] ^= 1 << (bit % 8);
                let (head, rest) = forged.split_at(head.len());
                let (body, tag) = rest.split_last_chunk().unwrap();
                assert_eq!(open(head, body, *tag), Err(Refusal::Forged), "bit {bit}");
            }
        }
    };
}

rfc!(the_portable_cipher_is_that_of_the_rfc, portable);
#[cfg(feature = "ring")]
rfc!(rings_cipher_is_that_of_the_rfc, ring);

/// Every length up to twice the longest datagram, each under a key and a nonce of its own: sealed by one, opened by the other.
#[cfg(feature = "ring")]
#[test]
fn one_cipher_opens_what_the_other_sealed() {
    for length in 0..2 * crate::wire::MAX_DATAGRAM {
        let key = Key::new(std::array::from_fn(|at| (7 * at + 31 * length) as u8));
        let nonce = std::array::from_fn(|at| (at * length) as u8);
        let head: [u8; 16] = std::array::from_fn(|at| (at ^ length) as u8);
        let plain: Vec<u8> = (0..length).map(|at| (at * at + length) as u8).collect();
        let (portable, ring) = (portable::Cipher::new(&key), Cipher::new(&key));
        let [mut ours, mut theirs] = [plain.clone(), plain.clone()];
        let tag = portable.seal(nonce, &head, &mut ours).unwrap();
        assert_eq!(Ok(tag), ring.seal(nonce, &head, &mut theirs));
        assert_eq!(ours, theirs);
        ring.open(nonce, &head, &mut ours, tag).unwrap();
        portable.open(nonce, &head, &mut theirs, tag).unwrap();
        assert_eq!((&ours, &theirs), (&plain, &plain), "{length} bytes");
    }
}
