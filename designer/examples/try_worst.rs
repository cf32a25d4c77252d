use steerguard_designer::Design;
use steerguard_designer::worst::*;
fn main() {
    let a: Vec<String> = std::env::args().collect();
    let mut d = Design::from_json(&std::fs::read_to_string(&a[1]).unwrap()).unwrap();
    if std::env::var("SHARE1").is_ok() {
        d.detector.evaluation.uncertainty_share = 1.0;
        if let Ok(l) = std::env::var("LEVEL") { d.detector.evaluation.threshold = l.parse().unwrap(); }
    }
    let c = d.configuration();
    let b: u64 = a[2].parse().unwrap();
    let seed: u64 = a[3].parse().unwrap();
    let fs: Vec<Family> = Family::of(&d.spec).into_iter().filter(|f| a.len() <= 4 || a[4..].iter().any(|x| x == f.name())).collect();
    let t = std::time::Instant::now();
    let ws = worst(&d.spec, &c, &fs, Search { budget: b, seed }, &|_| ()).unwrap();
    for w in &ws {
        let f = w.family;
        let (dr, at) = w.worst.as_ref().unwrap();
        println!("{:20} dim {} drives {} ratio {:.4} starts {:?} {:.1}s", f.name(), f.dimension(&d.spec), w.drives, w.ratio().unwrap(), w.ratio_at_random, t.elapsed().as_secs_f64());
        let v=&d.spec.vehicle;
        println!("    {at:?} m {:.3} I {:.3} Cf {:.3} Cr {:.3} start {:?} tyres {:?} h {:.3}", dr.vehicle.mass_kg/v.mass_kg, dr.vehicle.yaw_inertia_kg_m2/v.yaw_inertia_kg_m2, dr.vehicle.front_cornering_stiffness_n_per_rad/v.front_cornering_stiffness_n_per_rad, dr.vehicle.rear_cornering_stiffness_n_per_rad/v.rear_cornering_stiffness_n_per_rad, dr.start, dr.tyres, dr.vehicle.centre_of_gravity_height_m);
        let k=(at.time_s*100.0) as usize;
        let s=|x:&Vec<f64>| { let mut o=String::new(); let mut i=k.saturating_sub(250); while i<=k { o+=&format!("{:.2} ", x[i]); i+=25; } o };
        let deg:Vec<f64>=dr.courses.steering_rad.iter().map(|x|x.to_degrees()).collect();
        println!("    delta deg {}\n    v {}\n    bank {}\n    wind {}", s(&deg), s(&dr.courses.speed_m_per_s), s(&dr.courses.bank_deg), s(&dr.courses.wind_m_per_s));
    }
}
