//! Bytes with a checksum behind them: what is read is what was written, or known not to be.

use bytes::Bytes;

/// Bytes of the checksum, a blake3 hash of all before it.
const LENGTH: usize = blake3::OUT_LEN;

/// The checksum that goes behind `bytes`.
pub(super) fn seal(bytes: &[u8]) -> Bytes {
    Bytes::copy_from_slice(blake3::hash(bytes).as_bytes())
}

/// The bytes before the checksum; nothing where it is not theirs.
pub(super) fn opened(mut sealed: Bytes) -> Option<Bytes> {
    let seal = sealed.split_off(sealed.len().checked_sub(LENGTH)?);
    (blake3::hash(&sealed).as_bytes() == seal.as_ref()).then_some(sealed)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn sealed(bytes: &[u8]) -> Vec<u8> {
        [bytes, &seal(bytes)].concat()
    }

    #[test]
    fn what_was_sealed_is_opened() {
        for bytes in [&b""[..], b"a", &[0; 5000]] {
            assert_eq!(opened(sealed(bytes).into()).unwrap(), bytes);
        }
    }

    #[test]
    fn what_was_damaged_is_not() {
        let whole = sealed(&[7; 5000]);
        let mut damaged = vec![Vec::new(), vec![0; LENGTH], vec![0; whole.len()], whole[..4096].to_vec()];
        for place in [0, 2500, whole.len() - 1] {
            let mut changed = whole.clone();
            changed[place] ^= 1;
            damaged.push(changed);
        }
        damaged.push([&whole[..], b"\0"].concat());
        for bytes in damaged {
            assert_eq!(opened(bytes.into()), None);
        }
    }
}
