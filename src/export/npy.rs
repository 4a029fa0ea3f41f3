//! Arrays in NumPy's own format, version 1.0.

/// The `.npy` file of a rows × columns array of doubles in row-major order.
pub fn file(rows: usize, columns: usize, values: impl IntoIterator<Item = f64>) -> Vec<u8> {
    const ALIGNMENT: usize = 64;
    const MAGIC: &[u8] = b"\x93NUMPY\x01\x00";
    let mut header = format!("{{'descr': '<f8', 'fortran_order': False, 'shape': ({rows}, {columns}), }}");
    let preamble = MAGIC.len() + 2;
    let length = (preamble + header.len() + 1).next_multiple_of(ALIGNMENT) - preamble;
    header.extend(std::iter::repeat_n(' ', length - header.len() - 1));
    header.push('\n');
    let mut bytes = Vec::with_capacity(preamble + length + rows * columns * 8);
    bytes.extend_from_slice(MAGIC);
    // A header of two numbers stays far below the 64 KiB that two bytes can count.
    bytes.extend_from_slice(&(length as u16).to_le_bytes());
    bytes.extend_from_slice(header.as_bytes());
    bytes.extend(values.into_iter().flat_map(f64::to_le_bytes));
    bytes
}

#[cfg(test)]
mod tests {
    /// The bytes numpy 2 writes by `numpy.save(f, numpy.array([[1.0, 2.0]]))`.
    #[test]
    fn writes_what_numpy_writes() {
        let file = super::file(1, 2, [1.0, 2.0]);
        let header = "{'descr': '<f8', 'fortran_order': False, 'shape': (1, 2), }";
        assert_eq!(&file[..10], b"\x93NUMPY\x01\x00\x76\x00");
        assert_eq!(&file[10..10 + header.len()], header.as_bytes());
        assert_eq!(file.len(), 128 + 16);
        assert_eq!(file[127], b'\n');
        assert_eq!(&file[128..136], 1f64.to_le_bytes());
    }
}
