#include "atmosphere_settings.hpp"

#include "reader.hpp"

namespace alpenglow::sandbox {

Atmosphere read_atmosphere_settings(Reader& section) {
    Atmosphere air;
    auto model = static_cast<int>(air.model);
    section.name("model", sky_model_names, model);
    air.model = static_cast<SkyModel>(model);
    section.number("turbidity", 1.7, 10.0, air.turbidity);
    section.number("ozone_atm_cm", 0.0, 1.0, air.ozone_atm_cm);
    section.numbers("ground_albedo", 0.0, 1.0, air.ground_albedo);
    if (air.model == SkyModel::perez || air.model == SkyModel::asrc_cie) {
        section.number("clearness", 1.0, 12.0, air.clearness);
    }
    if (air.model == SkyModel::perez) {
        section.number("brightness", 0.01, 0.6, air.brightness);
    }
    if (air.model == SkyModel::cie_general) {
        section.number("cie_type", 1, 15, air.cie_type);
    }
    if (air.model != SkyModel::preetham && air.model != SkyModel::scattering) {
        section.number("zenith_cd_m2", 0.0, 100000.0, air.zenith_cd_m2);
    }
    return air;
}

} // namespace alpenglow::sandbox
