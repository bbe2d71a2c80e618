//! Where a raster lies, and in which units: what the file, and the files beside it, say of that.

use std::io::{BufRead, Seek};

use contract::limits::LENGTH_MAX_M;

use super::{RasterFile, Source};
use crate::crs::{CoordinateSystem, Heights, Identity, Kind};
use crate::geo_keys::agreed;
use crate::raster_header::{Extent, PixelIs, Placement, RasterHeader};
use crate::unit::LengthUnit;
use crate::{Georeference, Remark, TerrainError};

/// What programs write for the unit of a band that has none.
const NO_UNIT: [&str; 7] = ["unspecified", "unknown", "undefined", "none", "n/a", "unk", "null"];

/// Sides of a cell that differ by less than this, relative to each other, are equal but for rounding.
const SQUARE_WITHIN: f64 = 1e-4;

/// Where a raster lies, in metres, and the system that says so.
pub(super) struct Located {
    pub georeference: Georeference,
    pub system: Option<CoordinateSystem>,
    pub remarks: Vec<Remark>,
}

impl<R: BufRead + Seek> RasterFile<R> {
    pub(super) fn placement(&self) -> Result<Placement, TerrainError> {
        match (self.auxiliary.transform, &self.source) {
            (Some(transform), _) => Placement::of_transform(transform, 0.5, PixelIs::Area),
            (None, Source::GeoTiff(file)) => file.placement(),
            (None, Source::AsciiGrid(file)) => Ok(file.placement()),
        }
    }

    /// The coordinate system: what the auxiliary file, the file itself and its `.prj` file say together. A later text that is
    /// not understood says nothing against an earlier one.
    pub(super) fn system(&self) -> Result<Option<CoordinateSystem>, TerrainError> {
        let own = match &self.source {
            Source::GeoTiff(file) => file.keys.coordinate_system(),
            Source::AsciiGrid(_) => Ok(None),
        };
        let auxiliary =
            self.auxiliary.system.as_ref().map_or(Ok(None), |text| described(text, "its .aux.xml file"));
        let beside = self
            .projections
            .iter()
            .map(|(file, text)| described(text, "its .prj file").map_err(|error| error.of(file)));
        let mut stated: Option<CoordinateSystem> = None;
        for source in [auxiliary, own].into_iter().chain(beside) {
            let is_known = stated.as_ref().is_some_and(|system| system.kind.is_some());
            stated = match (stated, source) {
                (stated, Err(_)) if is_known => stated,
                (_, Err(error)) => return Err(error),
                (stated, Ok(None)) => stated,
                (None, Ok(next)) => next,
                (Some(stated), Ok(Some(next))) => Some(together(stated, next)?),
            };
        }
        Ok(stated)
    }

    /// [`RasterFile::placement`], with the reason if it is in a world file alone.
    fn placed(&self) -> Result<Placement, TerrainError> {
        match self.placement() {
            Err(TerrainError::NoGeoreference) if self.has_world_file => Err(TerrainError::Unsupported {
                what: "size of a cell",
                need: "ModelPixelScale with ModelTiepoint, or ModelTransformation",
                got: "a world file beside the raster alone".into(),
                remedy: "write it into the raster: gdal_translate IN.tif OUT.tif",
            }),
            placement => placement,
        }
    }

    /// The coordinate system. A text that is not understood says nothing against what the numbers look like.
    fn understood(&self, looks_like_degrees: bool) -> Result<Option<CoordinateSystem>, TerrainError> {
        let is_text = |error: &TerrainError| matches!(error, TerrainError::CoordinateSystem { .. });
        match self.system() {
            Err(error) if looks_like_degrees && is_text(&error) => Ok(None),
            Err(TerrainError::File { source, .. }) if looks_like_degrees && is_text(&source) => Ok(None),
            system => system,
        }
    }

    pub(super) fn located(&self) -> Result<Located, TerrainError> {
        let RasterHeader { width, height, .. } = self.header;
        let placement = self.placed()?;
        let extent = placement.extent(width, height);
        let looks_like_degrees = extent == Extent::Degrees;
        let system = self.understood(looks_like_degrees)?;
        let kind = system.as_ref().and_then(|system| system.kind);
        let middle = placement.middle(width, height);
        let degrees = |got: String, radius_m| {
            Err(TerrainError::Degrees { got, radius_m, centre_deg: None }.around(middle))
        };
        let Placement { x_size, y_size, west, north, pixel_is } = placement;
        match (kind, &system) {
            (Some(Kind::Degrees { radius_m }), Some(system)) => {
                return degrees(system.name.clone(), radius_m);
            }
            (Some(Kind::Geocentric), _) => {
                return Err(TerrainError::Unsupported {
                    what: "coordinate system",
                    need: "a projected one in metres",
                    got: "a geocentric one".into(),
                    remedy: "reproject it with gdalwarp -t_srs",
                });
            }
            (None, _) if looks_like_degrees => {
                let got = format!(
                    "cells of {x_size} around ({west}, {north}) and no coordinate system named; for metres, put \
                     LOCAL_CS[\"site\",UNIT[\"metre\",1]] into a .prj file beside it"
                );
                return degrees(got, None);
            }
            _ => {}
        }
        let mut remarks = Vec::new();
        if kind.is_none() && extent == Extent::LocalOrDegrees {
            remarks.push(Remark::TakenForLocal);
        }
        let unit = system.as_ref().and_then(|system| system.unit.clone());
        if let (Some(Kind::Plane), None, Some(system)) = (kind, &unit, &system) {
            remarks.push(Remark::NoUnit(system.name.clone()));
        }
        let unit = unit.unwrap_or_else(LengthUnit::metre);
        if !unit.is_metre() {
            remarks.push(Remark::CoordinatesConverted(unit.to_string()));
        }
        let unit_m = unit.metres;
        let [x_size, y_size, west, north] = [x_size, y_size, west, north].map(|length| length * unit_m);
        check_lattice([x_size, y_size], [west, north])?;
        let named = system.as_ref().filter(|system| system.kind.is_some());
        let identity = named.map_or_else(Identity::default, |system| system.identity.clone());
        let name = named.map(|system| system.name.clone());
        let georeference = Georeference {
            cell_size_m: x_size,
            west_m: west,
            south_m: north - f64::from(height - 1) * y_size,
            pixel_is,
            coordinate_system: name.unwrap_or_else(|| "none named, taken for metres".into()),
            identity,
            unit_m,
        };
        Ok(Located { georeference, system, remarks })
    }

    /// The unit of heights, which the band, the coordinate system, or both state; `None` for metres by default.
    pub(super) fn height_unit(
        &self,
        system: Option<&CoordinateSystem>,
    ) -> Result<Option<LengthUnit>, TerrainError> {
        let own = match &self.source {
            Source::GeoTiff(file) => file.unit.as_deref(),
            Source::AsciiGrid(_) => None,
        };
        let what = "unit of heights";
        let of_band = |name: Option<&str>| match name {
            Some(name) if !NO_UNIT.contains(&name.to_ascii_lowercase().as_str()) => {
                let unknown = || TerrainError::Unsupported {
                    what,
                    need: "a unit of length",
                    got: format!("{name:?}"),
                    remedy: "name the right one with gdal_edit.py -units metre FILE",
                };
                LengthUnit::of_words(name).map(Some).ok_or_else(unknown)
            }
            _ => Ok(None),
        };
        let stated = of_band(self.auxiliary.unit.as_deref().or(own))?;
        let of_label = of_band(self.label_unit.as_deref())?;
        let heights = system.map_or_else(Heights::default, |system| system.heights.clone());
        if heights.downwards {
            return Err(TerrainError::Unsupported {
                what: "heights",
                need: "heights, positive upwards",
                got: "depths, positive downwards".into(),
                remedy: "turn them over: gdal_calc.py -A IN.tif --calc=-A --outfile OUT.tif",
            });
        }
        if let Some(unit) = agreed(what, [stated, of_label, heights.unit])? {
            return Ok(Some(unit));
        }
        let plane = system.and_then(|system| system.unit.clone()).unwrap_or_else(LengthUnit::metre);
        if !plane.is_same_as(&LengthUnit::metre()) {
            return Err(TerrainError::Unsupported {
                what,
                need: "the unit of heights beside coordinates that are not in metres",
                got: format!("coordinates in the {plane} and nothing said of heights"),
                remedy: "state it with gdal_edit.py -units metre FILE, or -units ft, and so on",
            });
        }
        Ok(None)
    }

    /// How a further raster of the cells at `place` lies.
    pub(crate) fn lies(&self, place: &Georeference) -> Result<Lies, TerrainError> {
        let far_m = 1e-3 * place.cell_size_m;
        let side = f64::from(self.header.width.max(self.header.height));
        let is_near = |cell_m: f64, west_m: f64, south_m: f64| {
            let differs =
                [(place.cell_size_m - cell_m) * side, place.west_m - west_m, place.south_m - south_m];
            differs.iter().all(|by_m| by_m.abs() <= far_m)
        };
        let placement = match self.placement() {
            Err(TerrainError::NoGeoreference) => return Ok(Lies::There),
            placement => placement?,
        };
        // Where the raster does not say in which system it is, its numbers are in the unit of the model's.
        let south = placement.north - f64::from(self.header.height - 1) * placement.y_size;
        let [cell_m, west_m, south_m] =
            [placement.x_size, placement.west, south].map(|length| length * place.unit_m);
        if is_near(cell_m, west_m, south_m) && matches!(self.system(), Ok(None)) {
            return Ok(Lies::There);
        }
        let got = self.georeference()?;
        Ok(match got.identity.is_of(&place.identity) {
            _ if !is_near(got.cell_size_m, got.west_m, got.south_m) => Lies::Elsewhere(got),
            Some(true) => Lies::There,
            Some(false) => Lies::InOtherSystem(got),
            None => Lies::MaybeInOtherSystem(got),
        })
    }
}

/// Refuses cells that are not square, or of no size, and places that are none; all in metres.
fn check_lattice([x_size, y_size]: [f64; 2], [west, north]: [f64; 2]) -> Result<(), TerrainError> {
    for (what, got) in [("cell size", x_size), ("cell size", y_size)] {
        if !(got.is_finite() && got > 0.0 && got <= LENGTH_MAX_M) {
            return Err(TerrainError::Value { what, need: "a length above 0 m, at most 1e6 m", got });
        }
    }
    for (what, got) in [("easting", west), ("northing", north)] {
        if !got.is_finite() {
            return Err(TerrainError::Value { what, need: "a finite number", got });
        }
    }
    if (x_size - y_size).abs() > SQUARE_WITHIN * x_size {
        return Err(TerrainError::NotSquare { x_m: x_size, y_m: y_size });
    }
    Ok(())
}

/// How a further raster lies to the model.
pub(crate) enum Lies {
    /// On the same cells, or it does not say.
    There,
    /// On other cells.
    Elsewhere(Georeference),
    /// On cells of the same numbers in another coordinate system.
    InOtherSystem(Georeference),
    /// On cells of the same numbers, in a system of another name.
    MaybeInOtherSystem(Georeference),
}

/// What two texts say of one raster.
fn together(first: CoordinateSystem, next: CoordinateSystem) -> Result<CoordinateSystem, TerrainError> {
    let is_plane = |system: &CoordinateSystem| system.kind == Some(Kind::Plane);
    if is_plane(&first) && next.kind.is_some() && !is_plane(&next) {
        return Err(TerrainError::Unsupported {
            what: "coordinate system",
            need: "one, in metres",
            got: format!("{} in one place and {} in another", first.name, next.name),
            remedy: "remove the file beside the raster that is wrong, or correct it",
        });
    }
    let unit = match is_plane(&next) {
        true => agreed("unit of coordinates", [first.unit.clone(), next.unit.clone()])?,
        false => first.unit.clone(),
    };
    let heights = Heights {
        unit: agreed("unit of heights", [first.heights.unit.clone(), next.heights.unit.clone()])?,
        downwards: first.heights.downwards || next.heights.downwards,
        maybe_feet: first.heights.maybe_feet.clone().or(next.heights.maybe_feet.clone()),
    };
    let radius_m = first.radius_m.or(next.radius_m);
    let named = if first.kind.is_some() { first } else { next };
    Ok(CoordinateSystem { unit, heights, radius_m, ..named })
}

/// The system that `text` describes; errors and degrees name `whose` text it is.
fn described(text: &str, whose: &str) -> Result<Option<CoordinateSystem>, TerrainError> {
    let system = CoordinateSystem::of_text(text).map_err(|error| {
        let got = error.split_once("got ").map_or(String::new(), |(_, got)| got.to_owned());
        let need = error.split_once(", got ").map_or(error.clone(), |(need, _)| need.to_owned());
        TerrainError::CoordinateSystem { need, got }
    })?;
    Ok(system.map(|mut system| {
        if matches!(system.kind, Some(Kind::Degrees { .. })) {
            system.name = format!("{}, says {whose}", system.name);
        }
        system
    }))
}
