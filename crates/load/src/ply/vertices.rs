//! The table of vertices.

use sahl_math::{Vec2, Vec3};

use super::PlyError;
use super::header::{Element, Kind, Scalar};
use super::values::Values;

/// The columns of the vertices that are read.
#[derive(Debug, Default)]
pub(super) struct Vertices {
    pub(super) positions: Vec<Vec3>,
    pub(super) normals: Option<Vec<Vec3>>,
    pub(super) uvs: Option<Vec<Vec2>>,
}

/// What a row holds: position, normal, texture coordinates.
type Record = [f32; 8];
const POSITION: usize = 0;
const NORMAL: usize = 3;
const UV: usize = 6;

/// The names of texture coordinates in use; the first pair that is there counts.
const UV_NAMES: [[&str; 2]; 4] =
    [["u", "v"], ["s", "t"], ["texture_u", "texture_v"], ["texture_s", "texture_t"]];

/// Which columns go where.
struct Layout {
    /// For each property its place in the record, if it is wanted.
    slots: Vec<Option<usize>>,
    has_normals: bool,
    has_uvs: bool,
}

impl Layout {
    fn new(element: &Element, warnings: &mut Vec<String>) -> Result<Self, PlyError> {
        let mut slots = vec![None; element.properties.len()];
        let mut assign = |names: &[&str], first_slot: usize| {
            let columns: Option<Vec<usize>> = names.iter().map(|name| element.position(name)).collect();
            for (column, slot) in columns.iter().flatten().zip(first_slot..) {
                slots[*column] = Some(slot);
            }
            columns.is_some()
        };
        if !assign(&["x", "y", "z"], POSITION) {
            return Err(PlyError::at(element.offset, "the vertices have no properties `x`, `y` and `z`"));
        }
        let has_normals = assign(&["nx", "ny", "nz"], NORMAL);
        let has_uvs = UV_NAMES.iter().any(|names| assign(names, UV));
        if !has_normals && ["nx", "ny", "nz"].iter().any(|name| element.position(name).is_some()) {
            warnings.push("the normals lack one of `nx`, `ny`, `nz` and are ignored".to_owned());
        }
        let wanted = element.properties.iter().zip(&slots).filter(|(_, slot)| slot.is_some());
        for (property, _) in wanted {
            if matches!(property.kind, Kind::List { .. }) {
                let message = format!("the property `{}` is a list: expected a number", property.name);
                return Err(PlyError::at(property.offset, message));
            }
        }
        Ok(Self { slots, has_normals, has_uvs })
    }

    /// The width of a row in bytes and the columns that are wanted, if there are no lists.
    fn fixed(&self, element: &Element) -> Option<(usize, Vec<Column>)> {
        let mut columns = Vec::new();
        let mut stride = 0;
        for (property, slot) in element.properties.iter().zip(&self.slots) {
            let Kind::Scalar(scalar) = property.kind else { return None };
            columns.extend(slot.map(|slot| Column { slot, scalar, offset: stride }));
            stride += scalar.size();
        }
        Some((stride, columns))
    }
}

/// A column of a table without lists.
struct Column {
    slot: usize,
    scalar: Scalar,
    /// Bytes from the start of the row.
    offset: usize,
}

impl Vertices {
    pub(super) fn read(
        element: &Element,
        values: &mut impl Values,
        warnings: &mut Vec<String>,
    ) -> Result<Self, PlyError> {
        let layout = Layout::new(element, warnings)?;
        let most = values.most_rows(element.properties.iter().map(|property| property.kind));
        let capacity = usize::try_from(element.count).unwrap_or(most).min(most);
        let mut vertices = Self {
            positions: Vec::with_capacity(capacity),
            normals: layout.has_normals.then(|| Vec::with_capacity(capacity)),
            uvs: layout.has_uvs.then(|| Vec::with_capacity(capacity)),
        };
        if !vertices.read_fixed(element, &layout, values)? {
            for row in 0..element.count {
                let offset = values.offset();
                let record =
                    read_record(element, &layout, values).map_err(|error| element.in_row(row, error))?;
                vertices.push(&record, offset)?;
            }
        }
        vertices.clean_uvs(warnings);
        Ok(vertices)
    }

    /// Reads binary rows of one width, if that is what follows and all of them are there.
    fn read_fixed(
        &mut self,
        element: &Element,
        layout: &Layout,
        values: &mut impl Values,
    ) -> Result<bool, PlyError> {
        let Some((stride, columns)) = layout.fixed(element) else { return Ok(false) };
        let Some(rows) = values.rows(stride, element.count) else { return Ok(false) };
        for (offset, row) in rows.iter() {
            let mut record = Record::default();
            for column in &columns {
                record[column.slot] = rows.float(column.scalar, row, column.offset);
            }
            self.push(&record, offset)?;
        }
        Ok(true)
    }

    fn push(&mut self, record: &Record, offset: usize) -> Result<(), PlyError> {
        let position = Vec3::new(record[POSITION], record[POSITION + 1], record[POSITION + 2]);
        if !position.is_finite() {
            let index = self.positions.len();
            let [x, y, z] = position.into();
            return Err(PlyError::at(
                offset,
                format!("the position of vertex {index} is not finite: {x} {y} {z}"),
            ));
        }
        self.positions.push(position);
        if let Some(normals) = &mut self.normals {
            normals.push(Vec3::new(record[NORMAL], record[NORMAL + 1], record[NORMAL + 2]));
        }
        if let Some(uvs) = &mut self.uvs {
            uvs.push(Vec2::new(record[UV], record[UV + 1]));
        }
        Ok(())
    }

    /// Replaces texture coordinates that are not finite: they colour a few triangles wrongly, and harm nothing else.
    fn clean_uvs(&mut self, warnings: &mut Vec<String>) {
        let Some(uvs) = &mut self.uvs else { return };
        let mut count = 0;
        for uv in uvs.iter_mut().filter(|uv| !uv.is_finite()) {
            *uv = Vec2::ZERO;
            count += 1;
        }
        if count > 0 {
            warnings.push(format!("{count} texture coordinates that are not finite are taken for zero"));
        }
    }
}

fn read_record(element: &Element, layout: &Layout, values: &mut impl Values) -> Result<Record, PlyError> {
    let mut record = Record::default();
    for (property, slot) in element.properties.iter().zip(&layout.slots) {
        match (property.kind, slot) {
            (Kind::Scalar(scalar), Some(slot)) => record[*slot] = values.float(scalar)?,
            (kind, _) => values.skip(kind)?,
        }
    }
    Ok(record)
}
