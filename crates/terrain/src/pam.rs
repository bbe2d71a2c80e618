//! The `.aux.xml` file that GDAL and ArcGIS write beside a raster (GDAL's Persistent Auxiliary Metadata).

use std::path::Path;

use roxmltree::{Document, Node};

use crate::number::number;
use crate::{TerrainError, sidecar};

/// What the file says of the first band, and of where the raster lies. It stands above what the raster itself says.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Auxiliary {
    pub nodata: Option<f64>,
    pub scale: Option<f64>,
    pub offset: Option<f64>,
    pub unit: Option<String>,
    /// Text of the coordinate system.
    pub system: Option<String>,
    /// Easting of the corner, its change a column and a row; the same of the northing.
    pub transform: Option<[f64; 6]>,
}

impl Auxiliary {
    /// Reads the file beside the raster at `path`; nothing if there is none.
    ///
    /// # Errors
    /// [`TerrainError::File`] if it is no such file, or a number in it is none.
    pub fn beside(path: &Path) -> Result<Self, TerrainError> {
        let Some(file) = sidecar::appended(path, ".aux.xml") else { return Ok(Self::default()) };
        sidecar::text(&file).and_then(|text| Self::read(&text)).map_err(|error| error.of(&file))
    }

    fn read(text: &str) -> Result<Self, TerrainError> {
        let malformed = |need: &str, got: String| TerrainError::Malformed {
            what: "auxiliary file",
            need: need.into(),
            got,
        };
        let document = Document::parse(text).map_err(|error| malformed("XML", error.to_string()))?;
        let root = document.root_element();
        if !is_called(root, "PAMDataset") {
            return Err(malformed("PAMDataset as its root", format!("{:?}", root.tag_name().name())));
        }
        // ArcGIS writes a text of its own.
        let of_esri = || {
            let place = root.descendants().find(|node| is_called(*node, "SpatialReference"))?;
            child(place, "WKT")
        };
        let mut auxiliary = Self { system: child(root, "SRS").or_else(of_esri), ..Self::default() };
        if let Some(text) = child(root, "GeoTransform") {
            let numbers: Vec<f64> = text.split(',').filter_map(|number| number.trim().parse().ok()).collect();
            let transform = numbers
                .try_into()
                .map_err(|_| malformed("a GeoTransform of 6 numbers", format!("{text:?}")))?;
            auxiliary.transform = Some(transform);
        }
        let is_first = |band: &Node| band.attribute("band").is_none_or(|number| number.trim() == "1");
        let bands = || root.children().filter(|node| is_called(*node, "PAMRasterBand")).filter(is_first);
        // A band may have several parts.
        let of_band = |name: &str| bands().find_map(|band| child(band, name));
        let number = |name: &'static str| match of_band(name) {
            None => Ok(None),
            Some(text) => match number(&text) {
                Some(number) => Ok(Some(number)),
                None => Err(malformed("a number", format!("{name} {text:?}"))),
            },
        };
        auxiliary.nodata = number("NoDataValue")?;
        auxiliary.offset = number("Offset")?;
        auxiliary.scale = number("Scale")?;
        for (name, is_right) in [
            ("Scale", auxiliary.scale.is_none_or(|scale| scale.is_finite() && scale != 0.0)),
            ("Offset", auxiliary.offset.is_none_or(f64::is_finite)),
        ] {
            if !is_right {
                return Err(malformed("a finite scale other than 0 and a finite offset", name.into()));
            }
        }
        auxiliary.unit = of_band("UnitType");
        Ok(auxiliary)
    }
}

/// The text of a child, without the space around it; `None` if it is empty.
fn child(node: Node, name: &str) -> Option<String> {
    let text = node.children().find(|child| is_called(*child, name))?.text()?.trim();
    if text.is_empty() { None } else { Some(text.into()) }
}

/// Whether it is an element of this name, whatever the case of its letters.
fn is_called(node: Node, name: &str) -> bool {
    node.tag_name().name().eq_ignore_ascii_case(name)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_said_of_the_first_band_and_of_the_place_is_read() {
        let text = "<PAMDataset>\n<SRS dataAxisToSRSAxisMapping=\"1,2\">EPSG:2263</SRS>\n<GeoTransform> 5e5, 1, 0, 4e6, 0, -1</GeoTransform>\n\
             <PAMRasterBand band=\"2\"><Scale>7</Scale></PAMRasterBand>\n<PAMRasterBand band=\"1\">\
             <NoDataValue le_hex_equiv=\"0\">-1.5e+03</NoDataValue><UnitType>ft</UnitType><Offset>100</Offset><Scale>0.01</Scale>\
             </PAMRasterBand></PAMDataset>";
        let expected = Auxiliary {
            nodata: Some(-1500.0),
            scale: Some(0.01),
            offset: Some(100.0),
            unit: Some("ft".into()),
            system: Some("EPSG:2263".into()),
            transform: Some([5e5, 1.0, 0.0, 4e6, 0.0, -1.0]),
        };
        assert_eq!(Auxiliary::read(text).unwrap(), expected);
        let parts = "<pamdataset><pamrasterband band=\"1\"/><PAMRasterBand band=\"1\"><scale>2</scale>\
                     <NODATAVALUE>-1.#QNAN</NODATAVALUE></PAMRasterBand></pamdataset>";
        let parts = Auxiliary::read(parts).unwrap();
        let esri = "<PAMDataset><Metadata><GeodataXform><SpatialReference><WKT>EPSG:2263</WKT></SpatialReference>\
                    </GeodataXform></Metadata></PAMDataset>";
        assert_eq!(Auxiliary::read(esri).unwrap().system.as_deref(), Some("EPSG:2263"));
        assert!(parts.scale == Some(2.0) && parts.nodata.is_some_and(f64::is_nan));
        assert_eq!(Auxiliary::read("<PAMDataset/>").unwrap(), Auxiliary::default());
    }

    #[test]
    fn what_is_no_auxiliary_file_is_refused() {
        for (text, says) in [
            ("hello", "need XML"),
            ("<html><body/></html>", "PAMDataset as its root"),
            ("<PAMDataset><GeoTransform>1, 2</GeoTransform></PAMDataset>", "6 numbers"),
            ("<PAMDataset><PAMRasterBand><Scale>two</Scale></PAMRasterBand></PAMDataset>", "Scale \"two\""),
            ("<PAMDataset><PAMRasterBand><Scale>0</Scale></PAMRasterBand></PAMDataset>", "other than 0"),
        ] {
            let refused = Auxiliary::read(text).unwrap_err().to_string();
            assert!(refused.contains(says), "{refused}");
        }
    }
}
