//! stdin: n, then drives: configuration json path arg. Feeds signals to the whole detector.
use std::io::{Read, Write};
use steerguard_detector::*;
fn main() {
    let mut args = std::env::args().skip(1);
    let configuration: Configuration =
        serde_json::from_str(&std::fs::read_to_string(args.next().unwrap()).unwrap()).unwrap();
    let mut bytes = Vec::new();
    std::io::stdin().read_to_end(&mut bytes).unwrap();
    let mut it = bytes.chunks_exact(8).map(|b| f64::from_le_bytes(b.try_into().unwrap()));
    let mut next = || it.next().unwrap();
    let n = next() as usize;
    let mut out = std::io::BufWriter::new(std::io::stdout());
    for _ in 0..n {
        let len = next() as usize;
        let mut d = Detector::new(&configuration).unwrap();
        for _ in 0..len {
            let y = Measurement { v_x_m_per_s: next(), r_rad_per_s: next() };
            let u = Input { t_eng_n_m: next(), delta_rad: next() };
            let _ = next();
            let o = *d.sample(y, u);
            let m = o.monitor == Monitor::Monitoring;
            let e = o.estimate.unwrap_or_default();
            for x in [
                o.second_ratio,
                o.j_rms / o.j_th,
                f64::from(u8::from(m)),
                f64::from(u8::from(o.alarm)),
                match o.alarm_cause {
                    AlarmCause::None => 0.0,
                    AlarmCause::Residual => 1.0,
                    AlarmCause::Range => 2.0,
                    AlarmCause::SecondTest => 3.0,
                },
                e.fault_rad,
                e.bound_rad,
                e.age_samples as f64,
            ] {
                out.write_all(&x.to_le_bytes()).unwrap();
            }
        }
    }
}
