// The section `transfer` of a scene.
#pragma once

#include <string>

namespace alpenglow::sandbox {

class Reader;

// What of the light's ways a surface knows: its own normal, what stands in between, what bounces off the rest.
enum class TransferLevel { unshadowed, shadowed, interreflected };
// Who takes the dot products: the CPU or the vertex shader; `automatic` leaves them to the shader in full quality.
enum class TransferPath { automatic, cpu, shader };

// What deringing keeps from going negative in the light of diffuse things: nothing, what an open surface gets, the
// radiance from any direction (which occluders can pick out), or halfway between these two. Gloss and smoke are always
// lit by a radiance that is nowhere negative.
enum class TransferWindow { none, irradiance, halfway, radiance };

// Of a scene with things whose light is baked.
struct TransferSettings {
    TransferLevel level = TransferLevel::interreflected;
    TransferPath path = TransferPath::automatic;
    TransferWindow window = TransferWindow::halfway;
    float detail = 1.0F; // vertices, relative
    std::string mesh;    // an OBJ or glTF file that stands in for the figure; empty: none
};

[[nodiscard]] TransferSettings read_transfer_settings(Reader& section);

} // namespace alpenglow::sandbox
