//! PSNR over total bits per sample of real volumes (`cvr_codec_tests::measure`).

fn main() {
    cvr_codec_tests::measure::main(&cvr_rvq::Rvq);
}
