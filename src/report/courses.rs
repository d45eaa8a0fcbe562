//! The passes of a plan for chart plotters and maps: KML, GPX and `GeoJSON`.

use std::fmt::Write;

use serde_json::{Value, json};

use crate::results::{PlanResult, PlannedPass};

/// A course to draw.
struct Course<'a> {
    name: String,
    sailed: bool,
    pass: &'a PlannedPass,
    /// Longitude and latitude of begin and end, degrees.
    ends: [[f64; 2]; 2],
}

/// What is sailed already, then what is to be sailed in its order; a pass that is sailed several times stands once.
fn courses(result: &PlanResult) -> Vec<Course<'_>> {
    let sailed = result.sailed.iter().enumerate();
    let sailed = sailed.map(|(k, pass)| (format!("sailed {}", k + 1), true, pass));
    let mut order: Vec<(u64, Vec<usize>)> = vec![];
    for (k, step) in result.chosen.iter().enumerate() {
        match order.iter_mut().find(|(c, _)| *c == step.candidate) {
            Some((_, places)) => places.push(k + 1),
            None => order.push((step.candidate, vec![k + 1])),
        }
    }
    let to_sail = order.iter().filter_map(|(candidate, places)| {
        let pass = &result.candidates.get(*candidate as usize)?.pass;
        let places: Vec<String> = places.iter().map(usize::to_string).collect();
        Some((format!("pass {}", places.join(", ")), false, pass))
    });
    sailed
        .chain(to_sail)
        .filter_map(|(number, sailed, pass)| {
            Some(Course {
                name: format!("{number}: {}", pass.name),
                sailed,
                pass,
                ends: [lon_lat(pass.begin_deg?), lon_lat(pass.end_deg?)],
            })
        })
        .collect()
}

/// From latitude and longitude.
fn lon_lat([latitude, longitude]: [f64; 2]) -> [f64; 2] {
    [longitude, latitude]
}

/// KML 2.2.
#[must_use]
pub fn kml(result: &PlanResult) -> String {
    let mut text = format!(
        "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<kml xmlns=\"http://www.opengis.net/kml/2.2\">\n<Document>\n<name>{}</name>\n",
        escaped(&result.scenario)
    );
    text.push_str("<Style id=\"sailed\"><LineStyle><color>ff786b5b</color><width>2</width></LineStyle></Style>\n");
    text.push_str("<Style id=\"chosen\"><LineStyle><color>ff0078e0</color><width>4</width></LineStyle></Style>\n");
    for course in courses(result) {
        let style = if course.sailed { "sailed" } else { "chosen" };
        let ends = course.ends.map(|[lon, lat]| format!("{lon:.9},{lat:.9}"));
        let _ = writeln!(
            text,
            "<Placemark><name>{}</name><styleUrl>#{style}</styleUrl><LineString><coordinates>{}</coordinates></LineString></Placemark>",
            escaped(&course.name),
            ends.join(" ")
        );
    }
    text + "</Document>\n</kml>\n"
}

/// GPX 1.1, a route per pass.
#[must_use]
pub fn gpx(result: &PlanResult) -> String {
    let mut text = "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<gpx version=\"1.1\" creator=\"boresight\" xmlns=\"http://www.topografix.com/GPX/1/1\">\n".to_owned();
    for course in courses(result) {
        let _ = writeln!(text, "<rte><name>{}</name>", escaped(&course.name));
        for ([lon, lat], end) in course.ends.iter().zip(["begin", "end"]) {
            let _ = writeln!(
                text,
                "<rtept lat=\"{lat:.9}\" lon=\"{lon:.9}\"><name>{end}</name></rtept>"
            );
        }
        text.push_str("</rte>\n");
    }
    text + "</gpx>\n"
}

/// `GeoJSON` (RFC 7946), a line per pass with its speed and heading.
///
/// # Errors
/// None for a result made by this program; `serde_json` does not promise it.
pub fn geojson(result: &PlanResult) -> serde_json::Result<Vec<u8>> {
    let feature = |course: &Course<'_>| {
        json!({
            "type": "Feature",
            "properties": {
                "name": course.name,
                "sailed": course.sailed,
                "distance_m": course.pass.distance_m,
                "speed_m_s": course.pass.speed_m_s,
                "crab_deg": course.pass.crab_deg,
            },
            "geometry": { "type": "LineString", "coordinates": course.ends },
        })
    };
    let features: Vec<Value> = courses(result).iter().map(feature).collect();
    super::json::lines(&json!({ "type": "FeatureCollection", "features": features }))
}

/// Text safe in XML, control characters left out.
fn escaped(raw: &str) -> String {
    let mut text = String::new();
    for letter in raw.chars() {
        match letter {
            '&' => text.push_str("&amp;"),
            '<' => text.push_str("&lt;"),
            '>' => text.push_str("&gt;"),
            '"' => text.push_str("&quot;"),
            letter if letter.is_control() => text.push(' '),
            letter => text.push(letter),
        }
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_safe_in_xml() {
        assert_eq!(
            escaped("a<b> & \"c\"\u{1}"),
            "a&lt;b&gt; &amp; &quot;c&quot; "
        );
    }
}
