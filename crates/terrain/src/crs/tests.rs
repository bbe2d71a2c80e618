//! Each dialect, in its own words.

use super::*;

fn read(text: &str) -> CoordinateSystem {
    CoordinateSystem::of_text(text).unwrap_or_else(|error| panic!("{error}: {text}")).expect("not empty")
}

fn refused(text: &str) -> String {
    CoordinateSystem::of_text(text).unwrap_err()
}

const MOON: &str = r#"GEOGCS["GCS_Moon_2000",DATUM["D_Moon_2000",SPHEROID["Moon_2000_IAU_IAG",1737400.0,0.0]],PRIMEM["Reference_Meridian",0.0],UNIT["Degree",0.0174532925199433]]"#;

/// P-DEM-CRS. Every dialect says whether cells are in degrees.
#[test]
fn degrees_are_degrees_in_every_dialect() {
    let compound =
        format!(r#"COMPD_CS["Moon + height",{MOON},VERT_CS["h",VERT_DATUM["h",2005],UNIT["metre",1]]]"#);
    let bound =
        format!(r#"BOUNDCRS[SOURCECRS[{MOON}],TARGETCRS[GEOGCRS["WGS 84"]],ABRIDGEDTRANSFORMATION["x"]]"#);
    let lower = MOON.to_lowercase();
    let broken = MOON.replace(',', ",\r\n    ");
    let round = MOON.replace('[', "(").replace(']', ")");
    let third = r#"GEOGCRS["WGS 84",CS[ellipsoidal,3],AXIS["h",up,LENGTHUNIT["metre",1]],ID["EPSG",4979]]"#;
    for text in [
        MOON,
        &compound,
        &bound,
        &lower,
        &broken,
        &round,
        third,
        r#"GEODCRS["Moon",CS[ellipsoidal,2]]"#,
        "EPSG:4326",
        "epsg:4326\n",
        "4326",
        "urn:ogc:def:crs:EPSG::4326",
        "http://www.opengis.net/def/crs/EPSG/0/4326",
        "IAU_2015:30100",
        "IAU:2015:49900",
        "EPSG:4326+5773",
        "+proj=longlat +a=1737400 +b=1737400 +no_defs",
        "+PROJ=LongLat +R=3396190",
        "+init=epsg:4326",
        "proj=longlat datum=WGS84",
        r#"{"type":"GeographicCRS","name":"WGS 84"}"#,
        r#"{"type":"CompoundCRS","name":"c","components":[{"type":"GeographicCRS"},{"type":"VerticalCRS"}]}"#,
        r#"{"type":"BoundCRS","source_crs":{"type":"GeographicCRS"}}"#,
        "Projection    GEOGRAPHIC\nDatum         WGS84\nUnits         DD\nZunits        NO\n",
        "PROJECTION geographic\r\nUNITS dd\r\n",
    ] {
        assert!(matches!(read(text).kind, Some(Kind::Degrees { .. })), "{text}");
    }
    for (text, radius_m) in
        [(MOON, 1_737_400.0), (compound.as_str(), 1_737_400.0), ("+proj=longlat +a=3396190", 3_396_190.0)]
    {
        assert_eq!(read(text).kind, Some(Kind::Degrees { radius_m: Some(radius_m) }), "{text}");
    }
}

/// P-DEM-CRS. Every dialect says what unit the coordinates are in.
#[test]
fn the_unit_of_a_plane_is_that_of_its_text_in_every_dialect() {
    let projected = |unit: &str| {
        format!(r#"PROJCS["p",{MOON},PROJECTION["SimpleCylindrical"],PARAMETER["x",6561666.667]{unit}]"#)
    };
    let foot_json = r#"{"type":"ProjectedCRS","name":"p","base_crs":{},"coordinate_system":{"subtype":"Cartesian","axis":[{"name":"E",
        "direction":"east","unit":{"type":"LinearUnit","name":"US survey foot","conversion_factor":0.304800609601219}}]}}"#;
    for (text, metres) in [
        (projected(""), None),
        (projected(r#",UNIT["Meter",1.0]"#), Some(1.0)),
        (projected(r#",UNIT["Foot_US",0.3048006096012192]"#), Some(0.304_800_609_601_219_2)),
        (projected(r#",UNIT["kilometre",1000,AUTHORITY["EPSG","9036"]]"#), Some(1000.0)),
        (projected(r#",AUTHORITY["EPSG","2263"]"#), Some(1200.0 / 3937.0)),
        (r#"PROJCRS["p",CS[Cartesian,2],AXIS["x",east,LENGTHUNIT["cm",0.01]]]"#.into(), Some(0.01)),
        (
            r#"PROJCRS["p",CS[Cartesian,2],AXIS["x",east],AXIS["y",north],LENGTHUNIT["yard",0.9144]]"#.into(),
            Some(0.9144),
        ),
        (r#"LOCAL_CS["site",UNIT["foot",0.3048]]"#.into(), Some(0.3048)),
        (r#"ENGCRS["site",CS[Cartesian,2],AXIS["x",east],LENGTHUNIT["metre",1]]"#.into(), Some(1.0)),
        (foot_json.into(), Some(0.304_800_609_601_219)),
        (
            r#"{"type":"ProjectedCRS","name":"p","id":{"authority":"EPSG","code":2263}}"#.into(),
            Some(1200.0 / 3937.0),
        ),
        ("EPSG:2263".into(), Some(1200.0 / 3937.0)),
        ("EPSG:32633".into(), Some(1.0)),
        ("EPSG: 32633".into(), Some(1.0)),
        ("EPSG 32633".into(), Some(1.0)),
        (r#"VERTCS["v",UNIT["Meter",1.0]],PROJCS["p",UNIT["Foot",0.3048]]"#.into(), Some(0.3048)),
        ("IAU_2015:30115".into(), Some(1.0)),
        ("+proj=utm +zone=33".into(), Some(1.0)),
        ("+proj=utm +zone=33 +units=us-ft".into(), Some(1200.0 / 3937.0)),
        ("+proj=eqc +to_meter=1000 +R=1737400".into(), Some(1000.0)),
        ("+proj=eqc +to_meter=1/2".into(), Some(0.5)),
        ("Projection UTM\nZone 33\nDatum NAD27\nUnits FEET\nZunits FEET\n".into(), Some(1200.0 / 3937.0)),
        ("Projection UTM\nUnits METERS\n".into(), Some(1.0)),
        ("Projection UTM\nUnits 2\n".into(), Some(0.5)),
    ] {
        let system = read(&text);
        assert_eq!(system.kind, Some(Kind::Plane), "{text}");
        let got = system.unit.map(|unit| unit.metres);
        assert!(got.zip(metres).map_or(got == metres, |(a, b)| (a - b).abs() < 1e-12), "{got:?} in {text}");
    }
    assert_eq!(read(r#"GEOCCS["c"]"#).kind, Some(Kind::Geocentric));
    assert_eq!(read("+proj=geocent").kind, Some(Kind::Geocentric));
}

/// P-DEM-UNITS.
/// P-DEM-CRS. The vertical part states the unit of heights and whether they are depths.
#[test]
fn heights_have_the_unit_and_the_direction_of_their_own_system() {
    let with = |vertical: &str| format!(r#"COMPD_CS["c",PROJCS["p",UNIT["m",1]],{vertical}]"#);
    let esri = r#"PROJCS["p",UNIT["Meter",1.0]],VERTCS["v",VDATUM["v"],PARAMETER["Direction",-1.0],UNIT["Foot",0.3048]]"#;
    let within =
        r#"PROJCS["p",UNIT["Meter",1.0],VERTCS["v",PARAMETER["Direction",1.0],UNIT["Centimeter",0.01]]]"#;
    let third = r#"PROJCRS["p",CS[Cartesian,3],AXIS["x",east,LENGTHUNIT["m",1]],AXIS["y",north,LENGTHUNIT["m",1]],AXIS["h",up,LENGTHUNIT["ft",0.3048]]]"#;
    for (text, metres, downwards) in [
        (with(r#"VERT_CS["v",VERT_DATUM["v",2005],UNIT["US survey foot",0.3048006096]]"#), Some(0.304_800_609_6), false),
        (with(r#"VERT_CS["v",UNIT["m",1],AXIS["Depth",DOWN]]"#), Some(1.0), true),
        (r#"COMPOUNDCRS["c",PROJCRS["p",LENGTHUNIT["m",1]],VERTCRS["v",CS[vertical,1],AXIS["h",up],LENGTHUNIT["km",1000]]]"#.into(), Some(1000.0), false),
        (r#"VERTCRS["v",AXIS["h",up,LENGTHUNIT["m",1]]]"#.into(), Some(1.0), false),
        (esri.into(), Some(0.3048), true),
        (within.into(), Some(0.01), false),
        (third.into(), Some(0.3048), false),
        ("EPSG:32633+6360".into(), Some(1200.0 / 3937.0), false),
        ("EPSG: 32633 + EPSG: 6360".into(), Some(1200.0 / 3937.0), false),
        ("EPSG:32633+EPSG:6360".into(), Some(1200.0 / 3937.0), false),
        ("urn:ogc:def:crs,crs:EPSG::32633,crs:EPSG::6360".into(), Some(1200.0 / 3937.0), false),
        (esri.replacen(",VERTCS", "\nVERTCS", 1), Some(0.3048), true),
        (esri.replacen(",VERTCS", "VERTCS", 1), Some(0.3048), true),
        (r#"VERTCS["v",UNIT["Foot",0.3048]],PROJCS["p",UNIT["Meter",1.0]]"#.into(), Some(0.3048), false),
        ("EPSG:32633+5703".into(), Some(1.0), false),
        ("EPSG:32633+6357".into(), Some(1.0), true),
        ("+proj=utm +zone=33 +vunits=us-ft".into(), Some(1200.0 / 3937.0), false),
        ("Projection UTM\nUnits METERS\nZunits 100\n".into(), Some(0.01), false),
        ("Projection UTM\nUnits METERS\nZunits NO\n".into(), None, false),
        (r#"{"type":"CompoundCRS","components":[{"type":"ProjectedCRS","id":{"authority":"EPSG","code":32633}},
            {"type":"VerticalCRS","coordinate_system":{"axis":[{"direction":"up","unit":"foot"}]}}]}"#.into(), Some(0.3048), false),
    ] {
        let heights = read(&text).heights;
        assert_eq!((heights.unit.map(|unit| unit.metres), heights.downwards), (metres, downwards), "{text}");
    }
}

#[test]
fn nothing_is_made_of_an_empty_text_and_foreign_ones_are_refused() {
    for empty in ["", " \r\n", "\u{feff}", "\0"] {
        assert_eq!(CoordinateSystem::of_text(empty), Ok(None));
    }
    for (text, says) in [
        ("hello", "well-known text, PROJJSON"),
        ("PROJCS[\"p\"] trailing", "well-known text, got"),
        ("PROJCS[\"p\"]]", "well-known text, got"),
        ("PROJCS[\"p\"],PROJCS[\"q\"]", "one coordinate system"),
        ("PROJCS[\"p\"", "a comma or a closing bracket"),
        ("GEOGCS[\"Moon", "a closing quote"),
        ("HELLO[\"p\"]", "HELLO[...]"),
        ("{\"type\":\"ProjectedCRS\"}", "coordinate_system"),
        ("{\"type\":\"Feature\"}", "\"Feature\""),
        ("{", "an error"),
        ("EPSG:99999", "EPSG:99999"),
        ("ESRI:102003", "EPSG or IAU"),
        ("+proj=utm +units=parsec", "parsec"),
        ("Projection UTM\nUnits CUBITS\n", "CUBITS"),
    ] {
        assert!(refused(text).contains(says), "{} of {text}", refused(text));
    }
    let deep = "PROJCS[".repeat(100_000);
    assert!(refused(&deep).contains("brackets within each other"));
    let json = r#"{"type":"BoundCRS","source_crs":"#.repeat(100) + "{}" + &"}".repeat(100);
    assert!(refused(&json).contains("within each other"), "{}", refused(&json));
}
