#include <alpenglow/prt/field_part.hpp>

#include <algorithm>
#include <string>

namespace alpenglow::prt {

Result<FieldPart> joined(std::vector<FieldPart> parts, TransferKind kind, std::uint64_t input_hash,
                         std::uint64_t settings_hash, std::size_t points, std::size_t width) {
    std::sort(parts.begin(), parts.end(), [](const FieldPart& a, const FieldPart& b) { return a.first < b.first; });
    FieldPart all;
    all.kind = kind;
    all.input_hash = input_hash;
    all.settings_hash = settings_hash;
    for (FieldPart& part : parts) {
        const std::string where =
            "part of points " + std::to_string(part.first) + " .. " + std::to_string(part.first + part.count);
        if (part.kind != kind || part.input_hash != input_hash) {
            return Error{"was baked for something else", where, "parts of one mesh, grid or density"};
        }
        if (part.settings_hash != settings_hash) {
            return Error{"was baked with other settings", where, "the same settings for all parts"};
        }
        if (part.first != all.count) {
            return Error{"points " + std::to_string(std::min(all.count, part.first)) + " .. " +
                             std::to_string(std::max(all.count, part.first)) +
                             (part.first > all.count ? " are missing" : " are there twice"),
                         where, "all parts, each once"};
        }
        if (part.values.size() != part.count * width) {
            return Error{std::to_string(part.values.size()) + " values", where, std::to_string(part.count * width)};
        }
        if (all.count == 0) {
            all.values = std::move(part.values);
            all.inside = std::move(part.inside);
        } else {
            all.values.insert(all.values.end(), part.values.begin(), part.values.end());
            all.inside.insert(all.inside.end(), part.inside.begin(), part.inside.end());
        }
        all.count += part.count;
        all.rays += part.rays;
        all.dark_points += part.dark_points;
        all.cpu_s += part.cpu_s;
    }
    if (all.count != points) {
        return Error{"points " + std::to_string(all.count) + " .. " + std::to_string(points) + " are missing", "parts",
                     "all parts, each once"};
    }
    return all;
}

} // namespace alpenglow::prt
