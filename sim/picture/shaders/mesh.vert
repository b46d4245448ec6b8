#version 330 core
// Every seed and part is an instance: the upper three rows of inst_m place it, the last row, which a pose leaves free,
// holds its colour.
layout(location = 0) in vec3 position;
layout(location = NORMAL_LOC) in vec3 normal;
layout(location = INST_M_LOC) in mat4 inst_m;

uniform mat4 V;
uniform mat4 P;

out vec3 frag_normal;
flat out vec3 frag_colour;

void main()
{
    vec3 place = mat4x3(inst_m[0].xyz, inst_m[1].xyz, inst_m[2].xyz, inst_m[3].xyz) * vec4(position, 1.0);
    gl_Position = P * V * vec4(place, 1.0);
    frag_normal = mat3(inst_m[0].xyz, inst_m[1].xyz, inst_m[2].xyz) * normal;
    frag_colour = vec3(inst_m[0].w, inst_m[1].w, inst_m[2].w);
}
