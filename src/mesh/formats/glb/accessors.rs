//! Numbers out of the buffers of a glTF file.

use gltf::accessor::sparse::IndexType;
use gltf::accessor::{Accessor, DataType};
use gltf::buffer::View;

use super::container::Container;

impl Container {
    /// The numbers of an accessor, `N` for each element, as they are meant: integers divided where they are normalised, and
    /// sparse ones put in their places.
    pub fn numbers<const N: usize>(&self, accessor: &Accessor) -> Result<Vec<[f64; N]>, String> {
        if accessor.dimensions().multiplicity() != N {
            return Err(format!("accessor {} does not have {N} numbers for each element", accessor.index()));
        }
        let (kind, normalised) = (accessor.data_type(), accessor.normalized());
        let element = |bytes: &[u8]| {
            let mut numbers = [0.0; N];
            for (number, bytes) in numbers.iter_mut().zip(bytes.chunks_exact(kind.size())) {
                *number = value(kind, normalised, bytes);
            }
            numbers
        };
        let mut all: Vec<[f64; N]> = match accessor.view() {
            Some(view) => {
                self.elements(&view, accessor.offset(), accessor.count(), accessor.size())?.map(element).collect()
            }
            None if accessor.sparse().is_some() => vec![[0.0; N]; accessor.count()],
            None => return Err(format!("accessor {} has no data", accessor.index())),
        };
        if let Some(sparse) = accessor.sparse() {
            let (indices, values) = (sparse.indices(), sparse.values());
            let size = match indices.index_type() {
                IndexType::U8 => 1,
                IndexType::U16 => 2,
                IndexType::U32 => 4,
            };
            let places = self.elements(&indices.view(), indices.offset(), sparse.count(), size)?;
            let values = self.elements(&values.view(), values.offset(), sparse.count(), accessor.size())?;
            for (place, value) in places.zip(values) {
                let here = all.get_mut(whole(place) as usize);
                *here.ok_or_else(|| format!("sparse accessor {} reaches beyond its elements", accessor.index()))? =
                    element(value);
            }
        }
        Ok(all)
    }

    /// The whole numbers of an accessor of unsigned scalars.
    pub fn indices(&self, accessor: &Accessor) -> Result<Vec<u32>, String> {
        let unsigned = matches!(accessor.data_type(), DataType::U8 | DataType::U16 | DataType::U32);
        if !unsigned || accessor.dimensions().multiplicity() != 1 {
            return Err("its indices are no unsigned integers".into());
        }
        if accessor.sparse().is_some() {
            return Ok(self.numbers::<1>(accessor)?.into_iter().map(|[index]| index as u32).collect());
        }
        let view = accessor.view().ok_or("its indices have no data")?;
        Ok(self.elements(&view, accessor.offset(), accessor.count(), accessor.size())?.map(whole).collect())
    }

    /// The bytes of each of `count` elements in a view, all proven to lie in the file.
    fn elements<'a>(
        &'a self,
        view: &View,
        offset: usize,
        count: usize,
        size: usize,
    ) -> Result<impl ExactSizeIterator<Item = &'a [u8]> + use<'a>, String> {
        let stride = view.stride().unwrap_or(size);
        let data = self.buffer(view.buffer().index());
        let within = view.offset().checked_add(view.length()).and_then(|end| data.get(view.offset()..end));
        let data = within.and_then(|view| view.get(offset..)).unwrap_or_default();
        let length = count.saturating_sub(1).checked_mul(stride).and_then(|length| length.checked_add(size));
        if stride < size || (count > 0 && length.is_none_or(|length| length > data.len())) {
            return Err(format!("buffer view {} reaches beyond its data", view.index()));
        }
        Ok((0..count).map(move |i| &data[i * stride..i * stride + size]))
    }
}

/// A number of a glTF file (glTF 2.0, §3.6.2.2 and §3.11).
fn value(kind: DataType, normalised: bool, bytes: &[u8]) -> f64 {
    let (number, largest) = match (kind, bytes) {
        (DataType::I8, &[a]) => (f64::from(a as i8), f64::from(i8::MAX)),
        (DataType::U8, &[a]) => (f64::from(a), f64::from(u8::MAX)),
        (DataType::I16, &[a, b]) => (f64::from(i16::from_le_bytes([a, b])), f64::from(i16::MAX)),
        (DataType::U16, &[a, b]) => (f64::from(u16::from_le_bytes([a, b])), f64::from(u16::MAX)),
        (DataType::U32, &[a, b, c, d]) => (f64::from(u32::from_le_bytes([a, b, c, d])), f64::from(u32::MAX)),
        (DataType::F32, &[a, b, c, d]) => return f64::from(f32::from_le_bytes([a, b, c, d])),
        _ => (f64::NAN, 1.0),
    };
    if normalised { (number / largest).max(-1.0) } else { number }
}

/// An unsigned integer of one, two or four bytes.
fn whole(bytes: &[u8]) -> u32 {
    match *bytes {
        [a] => a.into(),
        [a, b] => u16::from_le_bytes([a, b]).into(),
        [a, b, c, d] => u32::from_le_bytes([a, b, c, d]),
        _ => u32::MAX,
    }
}
