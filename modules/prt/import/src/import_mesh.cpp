#include <alpenglow/prt/import_mesh.hpp>

#include <assimp/Importer.hpp>
#include <assimp/postprocess.h>
#include <assimp/scene.h>

#include <algorithm>
#include <cmath>
#include <string>

#include <glm/geometric.hpp>

namespace alpenglow::prt {

Result<Mesh> import_mesh(const std::filesystem::path& path, const ImportOptions& options) {
    std::error_code code;
    if (!std::filesystem::is_regular_file(path, code)) {
        return Error{"is missing or not a file", path.string(), "an OBJ or glTF file"};
    }
    Assimp::Importer importer;
    // Points and lines stay out; a scale or a mirrored node is baked into the vertices.
    importer.SetPropertyInteger(AI_CONFIG_PP_SBP_REMOVE, aiPrimitiveType_POINT | aiPrimitiveType_LINE);
    const aiScene* scene = nullptr;
    try {
        scene = importer.ReadFile(path.string(), aiProcess_Triangulate | aiProcess_SortByPType |
                                                     aiProcess_PreTransformVertices | aiProcess_JoinIdenticalVertices);
    } catch (const std::exception& failure) { // a damaged file can make an importer throw
        return Error{std::string("cannot be read: ") + failure.what(), path.string(), "a sound OBJ or glTF file"};
    }
    if (scene == nullptr || (scene->mFlags & AI_SCENE_FLAGS_INCOMPLETE) != 0) {
        return Error{std::string("cannot be read: ") + importer.GetErrorString(), path.string(),
                     "a sound OBJ or glTF file"};
    }
    Mesh mesh;
    bool every_normal = true;
    bool every_texcoord = true;
    for (unsigned m = 0; m < scene->mNumMeshes; ++m) {
        every_normal = every_normal && scene->mMeshes[m]->HasNormals();
        every_texcoord = every_texcoord && scene->mMeshes[m]->HasTextureCoords(0);
    }
    const auto turn = [&](const aiVector3D& v) {
        return options.y_up ? glm::vec3(v.x, -v.z, v.y) : glm::vec3(v.x, v.y, v.z);
    };
    for (unsigned m = 0; m < scene->mNumMeshes; ++m) {
        const aiMesh& part = *scene->mMeshes[m];
        const auto first = static_cast<unsigned>(mesh.positions.size());
        glm::vec3 albedo(0.5F);
        aiColor4D colour;
        const aiMaterial& material = *scene->mMaterials[part.mMaterialIndex];
        if (material.Get(AI_MATKEY_BASE_COLOR, colour) == AI_SUCCESS ||
            material.Get(AI_MATKEY_COLOR_DIFFUSE, colour) == AI_SUCCESS) {
            albedo = glm::clamp(glm::vec3(colour.r, colour.g, colour.b), 0.0F, 1.0F);
        }
        for (unsigned v = 0; v < part.mNumVertices; ++v) {
            mesh.positions.push_back(turn(part.mVertices[v]));
            mesh.albedo.push_back(albedo);
            if (every_normal) {
                const glm::vec3 normal = turn(part.mNormals[v]);
                const float length = glm::length(normal);
                mesh.normals.push_back(length > 0.0F && std::isfinite(length) ? normal / length : glm::vec3(0.0F));
            }
            if (every_texcoord) {
                mesh.texcoords.emplace_back(part.mTextureCoords[0][v].x, part.mTextureCoords[0][v].y);
            }
        }
        for (unsigned f = 0; f < part.mNumFaces; ++f) {
            const aiFace& face = part.mFaces[f];
            if (face.mNumIndices == 3) {
                mesh.triangles.push_back(first + glm::uvec3(face.mIndices[0], face.mIndices[1], face.mIndices[2]));
            }
        }
    }
    if (mesh.triangles.empty()) {
        return Error{"holds no triangle", path.string(), "one triangle or more"};
    }
    if (!every_normal) {
        compute_normals(mesh);
    }
    return mesh;
}

} // namespace alpenglow::prt
