//! A glTF file's buffers and checked access to the vectors and indices in them.
//!
//! A buffer is the binary part of a GLB, a base64 `data:` URI, or a file next to the mesh. An accessor that reaches
//! beyond its buffer, or whose type does not fit its use, is an error.

use crate::scene::SceneError;
use crate::scene::mesh::{Reading, bad, open};
use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use gltf::accessor::DataType;
use gltf::buffer::{Source, View};
use gltf::{Accessor, Document};
use percent_encoding::percent_decode_str;
use std::collections::HashMap;
use std::collections::hash_map::Entry;
use std::fs;
use std::path::{Path, PathBuf};
use std::rc::Rc;

/// The content of all buffers of a document; those in the same file share it.
pub(super) struct Buffers(Vec<Rc<Vec<u8>>>);

/// The bytes at a URI, base64 `data:` or a file next to the mesh, which is taken from `files` where it is there.
pub(super) fn at(
    mesh: &mut Reading,
    uri: &str,
    files: &mut HashMap<PathBuf, Rc<Vec<u8>>>,
    error: &dyn Fn(&str) -> SceneError,
) -> Result<Rc<Vec<u8>>, SceneError> {
    if let Some(data) = uri.strip_prefix("data:") {
        let (_, text) = data.split_once(";base64,").ok_or_else(|| error("is no base64 data"))?;
        mesh.take(text.len())?;
        let data = STANDARD.decode(text);
        return Ok(Rc::new(data.map_err(|_| error("is no valid base64 data"))?));
    }
    let name = percent_decode_str(uri).decode_utf8_lossy();
    let file = Path::new(mesh.path).with_file_name("").join(&*name);
    let path = file.to_string_lossy().into_owned();
    match files.entry(fs::canonicalize(&file).unwrap_or(file)) {
        Entry::Occupied(read) => Ok(read.get().clone()),
        Entry::Vacant(new) => {
            let data = open(Path::new(&path));
            let unreadable = |source| SceneError::Unreadable { path: path.clone(), source };
            let mut data = data.map_err(unreadable)?;
            Ok(new.insert(Rc::new(mesh.whole(&path, &mut data)?)).clone())
        }
    }
}

impl Buffers {
    /// Loads the buffers of the document that was read from `mesh`.
    pub fn load(
        mesh: &mut Reading,
        document: &Document,
        mut blob: Option<Vec<u8>>,
    ) -> Result<Buffers, SceneError> {
        let path = mesh.path;
        let mut buffers = Vec::new();
        let mut files: HashMap<PathBuf, Rc<Vec<u8>>> = HashMap::new();
        for buffer in document.buffers() {
            let error = |what: &str| bad(path, None, format!("buffer {} {what}", buffer.index()));
            let data = match buffer.source() {
                Source::Bin => blob
                    .take()
                    .map(Rc::new)
                    .ok_or_else(|| error("is the binary part of a GLB, which is missing"))?,
                Source::Uri(uri) => at(mesh, uri, &mut files, &error)?,
            };
            if data.len() < buffer.length() {
                let (found, expected) = (data.len(), buffer.length());
                return Err(error(&format!("has {found} bytes, expected {expected}")));
            }
            buffers.push(data);
        }
        Ok(Buffers(buffers))
    }

    /// Bytes of all of them; what several share counts once.
    pub fn bytes(&self) -> usize {
        let each: HashMap<_, usize> =
            self.0.iter().map(|data| (Rc::as_ptr(data), data.len())).collect();
        each.values().sum()
    }

    /// The bytes of a view, if they are in its buffer.
    pub fn view(&self, view: &View) -> Option<&[u8]> {
        let end = view.offset().checked_add(view.length())?;
        self.0[view.buffer().index()].get(view.offset()..end)
    }

    /// The first `count` vectors, which is at most how many there are, of `N` floats, or of integers: those that are normalised stand for 0..=1 or -1..=1.
    pub fn vectors<const N: usize>(
        &self,
        accessor: &Accessor,
        count: usize,
    ) -> Result<Vec<[f32; N]>, String> {
        let found = accessor.dimensions().multiplicity();
        if found != N {
            return Err(format!(
                "accessor {} has {found} components, expected {N}",
                accessor.index()
            ));
        }
        let size = accessor.data_type().size();
        let (kind, normalized) = (accessor.data_type(), accessor.normalized());
        let scalar = |bytes: &[u8]| {
            let (value, most) = match kind {
                DataType::F32 => {
                    return f32::from_le_bytes([bytes[0], bytes[1], bytes[2], bytes[3]]);
                }
                DataType::U32 => {
                    let value = u32::from_le_bytes([bytes[0], bytes[1], bytes[2], bytes[3]]);
                    (value as f32, u32::MAX as f32)
                }
                DataType::U16 => (f32::from(u16::from_le_bytes([bytes[0], bytes[1]])), 65535.0),
                DataType::I16 => (f32::from(i16::from_le_bytes([bytes[0], bytes[1]])), 32767.0),
                DataType::U8 => (f32::from(bytes[0]), 255.0),
                DataType::I8 => (f32::from(bytes[0] as i8), 127.0),
            };
            // The least integer stands for -1 as the next one does.
            if normalized { (value / most).max(-1.0) } else { value }
        };
        let vector = |bytes: &[u8]| std::array::from_fn(|i| scalar(&bytes[i * size..]));
        self.elements(accessor, count, [0.0; N], vector)
    }

    /// Unsigned integers of any size.
    pub fn indices(&self, accessor: &Accessor) -> Result<Vec<u32>, String> {
        match (accessor.dimensions().multiplicity(), accessor.data_type()) {
            (1, DataType::U8 | DataType::U16 | DataType::U32) => {
                self.elements(accessor, accessor.count(), 0, wide)
            }
            _ => Err(format!("accessor {} is no list of indices", accessor.index())),
        }
    }

    /// The first `count` elements, each from its bytes: those of the view, or zero without one, with sparse ones in their place.
    fn elements<T: Copy>(
        &self,
        accessor: &Accessor,
        count: usize,
        zero: T,
        element: impl Fn(&[u8]) -> T,
    ) -> Result<Vec<T>, String> {
        let index = accessor.index();
        if accessor.count() < count {
            return Err(format!("accessor {index} has {}, expected {count}", accessor.count()));
        }
        let size = accessor.size();
        let beyond = |part: &str| format!("accessor {index} reaches {part}beyond its buffer");
        let mut elements = match accessor.view() {
            Some(view) => {
                let bytes = self.each(&view, accessor.offset(), size, count);
                bytes.ok_or_else(|| beyond(""))?.map(&element).collect()
            }
            None => vec![zero; count],
        };
        if let Some(sparse) = accessor.sparse() {
            let (indices, values) = (sparse.indices(), sparse.values());
            let width = indices.index_type().size();
            let numbers = self.each(&indices.view(), indices.offset(), width, sparse.count());
            let values = self.each(&values.view(), values.offset(), size, sparse.count());
            let both = numbers.zip(values).ok_or_else(|| beyond("with its sparse elements "))?;
            for (number, value) in both.0.map(wide).zip(both.1) {
                // Those behind the first `count` are not asked for.
                if number as usize >= accessor.count() {
                    let what = format!("expected one below {}", accessor.count());
                    return Err(format!("accessor {index} has the sparse index {number}, {what}"));
                }
                if let Some(place) = elements.get_mut(number as usize) {
                    *place = element(value);
                }
            }
        }
        Ok(elements)
    }

    /// The bytes of so many elements of a size in bytes, from an offset in a view on; nothing if they reach beyond it.
    fn each<'a>(
        &'a self,
        view: &View,
        offset: usize,
        size: usize,
        count: usize,
    ) -> Option<impl Iterator<Item = &'a [u8]> + use<'a>> {
        let stride = view.stride().unwrap_or(size).max(size);
        let bytes = self.view(view)?.get(offset..)?;
        let end = match count {
            0 => 0,
            _ => (count - 1).checked_mul(stride)?.checked_add(size)?,
        };
        (end <= bytes.len()).then(|| bytes.chunks(stride).take(count))
    }
}

/// An unsigned integer, its lowest byte first.
fn wide(bytes: &[u8]) -> u32 {
    bytes.iter().rev().fold(0, |value, &byte| value << 8 | u32::from(byte))
}
