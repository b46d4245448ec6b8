#version 330 core
// Matt surfaces under a soft light: ambient + direct (1 + n·l)²/4. No highlight, which would pull a seed's centre of brightness,
// and no gamma: the values are the light that falls on the sensor, so that averaging them is what a pixel does.
in vec3 frag_normal;
flat in vec3 frag_colour;

struct DirectionalLight { vec3 color; float intensity; vec3 direction; };
uniform vec3 ambient_light;
uniform DirectionalLight directional_lights[1];

layout(location = 0) out vec4 colour;

void main()
{
    float facing = 0.5 - 0.5 * dot(normalize(frag_normal), directional_lights[0].direction);
    float light = ambient_light.x + directional_lights[0].intensity * facing * facing;
    colour = vec4(min(frag_colour * light, 1.0), 1.0);
}
