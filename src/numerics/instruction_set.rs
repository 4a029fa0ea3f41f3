/// The instructions that linear algebra chooses among at run time, as this processor has them: where they differ, sums are
/// rounded otherwise and the last digits of results may differ.
pub fn instruction_set() -> &'static str {
    #[cfg(target_arch = "x86_64")]
    {
        if std::arch::is_x86_feature_detected!("avx512f") {
            return "x86_64-avx512";
        }
        if pulp::x86::V3::try_new().is_some() {
            return "x86_64-avx2";
        }
    }
    std::env::consts::ARCH
}
