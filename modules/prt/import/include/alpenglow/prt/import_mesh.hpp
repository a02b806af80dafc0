// Meshes from OBJ and glTF files, through Assimp.
#pragma once

#include <alpenglow/prt/mesh.hpp>

#include <filesystem>

namespace alpenglow::prt {

struct ImportOptions {
    bool y_up = true; // the file's +Y is up (glTF by its specification, OBJ by habit): turned to +Z
};

// All meshes of the file as one, node transforms applied, vertices with the same position, normal and texture
// coordinate joined. Diffuse material colours become albedo, as linear values. Normals of the file are kept; missing
// ones are computed. The result has passed `validate`-like checks of size only: the bake reports the rest.
[[nodiscard]] Result<Mesh> import_mesh(const std::filesystem::path& path, const ImportOptions& options = {});

} // namespace alpenglow::prt
