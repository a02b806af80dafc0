// The section `impostors` of a scene.
#pragma once

namespace alpenglow::sandbox {

class Reader;

// Clouds that are drawn by their pictures.
struct ImpostorSettings {
    int clouds = 100;          // of a field of its own; 0: none but what the scene has
    float field_m = 11000.0F;  // side of the square that they stand in
    float base_m = 2300.0F;    // of the clouds, above sea level
    float size_m = 620.0F;     // the longer side of a cloud, about
    float detail = 0.0F;       // strength of structure finer than voxels, see clouds::detailed_density()
    float opacity = 1.0F;      // optical thickness over the usual
    int craft = 7;             // aircraft that weave through them
    bool follow = true;        // the camera flies with them
    float max_error = 0.02F;   // relative RMSE of a picture that may go unnoticed
    int budget_texels = 16000; // worth of work on pictures a frame
    bool outlines = false;
    bool direct = false; // march every cloud in every frame instead
};

[[nodiscard]] ImpostorSettings read_impostor_settings(Reader& section);

} // namespace alpenglow::sandbox
