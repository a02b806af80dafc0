// Precomputed radiance transfer in a shader, from the same tables that the CPU reads (alpenglow/prt/transfer_table.hpp):
// upload TransferTable::blocks as it stands. This file is GLSL and C++ at once: tests compile it as both.
//
// Before including, define
//   ALPENGLOW_TRANSFER_ENCODING        0 float, 1 half, 2 8-bit, 3 CPCA
//   uint transfer_word(uint index)     32-bit word `index` of the table's blocks
//   vec3 transfer_light(uint i)        coefficient i of the light in the object's frame, as prt::shader_light writes it
//                                      (8-bit scales folded in); CPCA: value i of prt::light_clusters instead
#ifndef ALPENGLOW_TRANSFER_GLSL
#define ALPENGLOW_TRANSFER_GLSL

// Value `index` of the blocks.
float alpenglow_transfer_value(uint index) {
#if ALPENGLOW_TRANSFER_ENCODING == 0
    return uintBitsToFloat(transfer_word(index));
#elif ALPENGLOW_TRANSFER_ENCODING == 1
    vec2 pair = unpackHalf2x16(transfer_word(index >> 1));
    return (index & 1u) == 0u ? pair.x : pair.y;
#else
    int word = int(transfer_word(index >> 2));
    return float((word << int(24u - 8u * (index & 3u))) >> 24); // its byte, with its sign
#endif
}

#if ALPENGLOW_TRANSFER_ENCODING != 3

// One row (0 for vectors) of transfer times light: exit radiance of albedo 1 for vectors, a coefficient of transferred
// radiance for matrices. `coefficients` is the table's order squared, `lit` how many of them the light has (at most
// that), `rows` and `channels` the table's.
vec3 alpenglow_transfer_row(uint point, uint row, uint rows, uint channels, uint coefficients, uint lit) {
    uint width = rows * channels * coefficients;
    uint at = ((point >> 4) * width + row * channels * coefficients) * 16u + (point & 15u);
    vec3 sum = vec3(0.0F);
    if (channels == 1u) {
        for (uint i = 0u; i < lit; ++i) {
            sum += alpenglow_transfer_value(at + i * 16u) * transfer_light(i);
        }
    } else {
        uint channel = coefficients * 16u;
        for (uint i = 0u; i < lit; ++i) {
            uint value = at + i * 16u;
            sum += vec3(alpenglow_transfer_value(value), alpenglow_transfer_value(value + channel),
                        alpenglow_transfer_value(value + 2u * channel)) *
                   transfer_light(i);
        }
    }
    return sum;
}

// Vectors: exit radiance of albedo 1 at a vertex, texel or voxel.
vec3 alpenglow_transfer(uint point, uint channels, uint coefficients, uint lit) {
    return alpenglow_transfer_row(point, 0u, 1u, channels, coefficients, lit);
}

// Matrices, eq. 12 of the paper: `weights[i]` is kernel_l(i) y_i(R), R the reflected view direction in the object's frame.
vec3 alpenglow_transfer_glossy(uint point, uint rows, uint channels, uint coefficients, uint lit, float weights[36]) {
    vec3 sum = vec3(0.0F);
    for (uint row = 0u; row < rows; ++row) {
        sum += weights[row] * alpenglow_transfer_row(point, row, rows, channels, coefficients, lit);
    }
    return sum;
}

#else

// CPCA: exit radiance of albedo 1 at `slot` of the table (prt::vertex_slots), which belongs to `cluster`.
vec3 alpenglow_transfer_cpca(uint slot, uint cluster, uint components) {
    uint lit = cluster * (components + 1u);
    uint at = (slot >> 4) * components * 16u + (slot & 15u);
    vec3 sum = transfer_light(lit);
    for (uint j = 0u; j < components; ++j) {
        sum += alpenglow_transfer_value(at + j * 16u) * transfer_light(lit + 1u + j);
    }
    return sum;
}

#endif

#endif
