//! Coordinate reference systems as well-known text (OGC 01-009), as LAS 1.4 wants them.

use crate::geometry::Ellipsoid;

/// Name of the datum in the EPSG registry, with spheroid.
fn datum(ellipsoid: Ellipsoid) -> (&'static str, String) {
    let (name, datum, spheroid) = match ellipsoid {
        Ellipsoid::Wgs84 => ("WGS 84", "WGS_1984", "WGS 84"),
        Ellipsoid::Cgcs2000 => (
            "China Geodetic Coordinate System 2000",
            "China_2000",
            "CGCS2000",
        ),
    };
    let (a_m, inverse) = (ellipsoid.semi_major_axis_m(), 1.0 / ellipsoid.flattening());
    let inverse = format!("{inverse:.9}");
    (
        name,
        format!(
            "DATUM[\"{datum}\",SPHEROID[\"{spheroid}\",{a_m},{inverse}]],PRIMEM[\"Greenwich\",0]"
        ),
    )
}

/// Geocentric coordinates; EPSG 4978 for WGS84, 4479 for CGCS2000.
#[must_use]
pub fn geocentric(ellipsoid: Ellipsoid) -> String {
    let (name, datum) = datum(ellipsoid);
    let code = match ellipsoid {
        Ellipsoid::Wgs84 => 4978,
        Ellipsoid::Cgcs2000 => 4479,
    };
    let axes =
        "AXIS[\"Geocentric X\",OTHER],AXIS[\"Geocentric Y\",OTHER],AXIS[\"Geocentric Z\",NORTH]";
    format!("GEOCCS[\"{name}\",{datum},UNIT[\"metre\",1],{axes},AUTHORITY[\"EPSG\",\"{code}\"]]")
}

/// UTM, zone negative in the south; EPSG 326xx and 327xx for WGS84, no code for CGCS2000. Heights are ellipsoidal.
#[must_use]
pub fn utm(ellipsoid: Ellipsoid, zone: i8) -> String {
    let (name, datum) = datum(ellipsoid);
    let number = i32::from(zone.unsigned_abs());
    let (letter, northing_m, code) = if zone < 0 {
        ('S', 10_000_000, 32_700 + number)
    } else {
        ('N', 0, 32_600 + number)
    };
    let central_deg = 6 * number - 183;
    let authority = match ellipsoid {
        Ellipsoid::Wgs84 => format!(",AUTHORITY[\"EPSG\",\"{code}\"]"),
        Ellipsoid::Cgcs2000 => String::new(),
    };
    format!(
        "PROJCS[\"{name} / UTM zone {number}{letter}\",GEOGCS[\"{name}\",{datum},UNIT[\"degree\",0.0174532925199433]],\
         PROJECTION[\"Transverse_Mercator\"],PARAMETER[\"latitude_of_origin\",0],PARAMETER[\"central_meridian\",{central_deg}],\
         PARAMETER[\"scale_factor\",0.9996],PARAMETER[\"false_easting\",500000],PARAMETER[\"false_northing\",{northing_m}],\
         UNIT[\"metre\",1],AXIS[\"Easting\",EAST],AXIS[\"Northing\",NORTH]{authority}]"
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Parameters as in the EPSG registry: zone 50 is centred on 117 degrees east, 33 south on 15 degrees east.
    #[test]
    fn zones_have_their_registered_parameters() {
        let north = utm(Ellipsoid::Wgs84, 50);
        assert!(
            north.contains("\"central_meridian\",117]")
                && north.ends_with("AUTHORITY[\"EPSG\",\"32650\"]]"),
            "{north}"
        );
        assert!(north.contains("6378137,298.257223563]"), "{north}");
        let south = utm(Ellipsoid::Cgcs2000, -33);
        assert!(
            south.contains("\"central_meridian\",15]")
                && south.contains("\"false_northing\",10000000]"),
            "{south}"
        );
        assert!(
            !south.contains("EPSG") && south.contains("zone 33S"),
            "{south}"
        );
    }
}
