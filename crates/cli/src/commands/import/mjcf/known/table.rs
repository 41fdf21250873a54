//! The elements and attributes of MJCF that this importer looks at, as MuJoCo 4.0.0 lists them.

use super::Section;

/// The attributes of a pose.
const POSE: &str = "axisangle euler pos quat xyaxes zaxis";

/// The attributes of most actuators.
const ACTUATOR: &str = "\
    armature class cranklength cranksite ctrlrange damping delay gear group interp joint jointinparent \
    lengthrange name nsample slidersite tendon user";

/// Elements with their attributes: the section, the name, attributes of several elements, and their own ones.
pub(super) const KNOWN: [(Section, &str, &str, &str); 42] = [
    (Section::Root, "mujoco", "", "model"),
    (
        Section::Root,
        "compiler",
        "",
        "alignfree angle assetdir autolimits balanceinertia boundinertia boundmass conflict coordinate \
         discardvisual eulerseq fitaabb fusestatic inertiafromgeom inertiagrouprange meshdir passthrough \
         savecanonical savecompiled saveinertial settotalmass strippath texturedir usethread",
    ),
    (
        Section::Root,
        "option",
        "",
        "actuatorgroupdisable ccd_iterations ccd_tolerance cone density gravity impratio integrator iterations \
         jacobian ls_iterations ls_tolerance magnetic noslip_iterations noslip_tolerance o_friction o_margin \
         o_solimp o_solref sdf_initpoints sdf_iterations sleep_tolerance solver timestep tolerance viscosity \
         wind",
    ),
    (Section::Root, "worldbody", "", "axisangle childclass euler name pos quat xyaxes zaxis"),
    (Section::Root, "default", "", "class"),
    (Section::Root, "include", "", "file prefix"),
    (
        Section::Compiler,
        "lengthrange",
        "",
        "accel interval inttotal maxforce mode timeconst timestep tolrange useexisting uselimit",
    ),
    (
        Section::Option,
        "flag",
        "",
        "actuation autoreset clampctrl constraint contact damper diagexact energy equality eulerdamp \
         filterparent frictionloss fwdinv gravity invdiscrete ipc island limit midphase multiccd nativeccd \
         override refsafe sensor sleep speculative spring warmstart",
    ),
    (Section::Body, "body", POSE, "childclass fuse gravcomp mocap name simple sleep user"),
    (Section::Body, "frame", POSE, "childclass name"),
    (Section::Body, "inertial", POSE, "diaginertia fullinertia mass"),
    (
        Section::Body,
        "joint",
        "",
        "actuatorfrclimited actuatorfrcrange actuatorgravcomp armature axis class damping frictionloss group \
         limited margin name pos range ref solimpfriction solimplimit solreffriction solreflimit springdamper \
         springref springyield stiffness type user",
    ),
    (Section::Body, "freejoint", "", "align group name"),
    (
        Section::Body,
        "geom",
        POSE,
        "adhesion castshadow class conaffinity condim contype density fitscale fluidcoef fluidshape friction \
         fromto gap group hfield margin mass material mesh name priority rgba shellinertia size solimp solmix \
         solref surfacevel type user",
    ),
    (Section::Body, "site", POSE, "class fromto group material mesh name rgba size type user"),
    (
        Section::Body,
        "camera",
        POSE,
        "class focal focalpixel fovy ipd mode name output principal principalpixel projection resolution \
         sensorsize target user",
    ),
    (
        Section::Body,
        "light",
        "",
        "active ambient attenuation bulbradius castshadow class cutoff diffuse dir directional exponent \
         intensity mode name pos range softness specular target texture type",
    ),
    (Section::Equality, "connect", "", "active anchor body1 body2 class name site1 site2 solimp solref"),
    (
        Section::Equality,
        "weld",
        "",
        "active anchor body1 body2 class name relpose site1 site2 solimp solref torquescale",
    ),
    (Section::Equality, "joint", "", "active class joint1 joint2 name polycoef solimp solref"),
    (Section::Equality, "tendon", "", "active class name polycoef solimp solref tendon1 tendon2"),
    (Section::Equality, "flex", "", "active class flex name solimp solref"),
    (Section::Equality, "flexstrain", "", "active cell class flex name solimp solref"),
    (
        Section::Actuator,
        "general",
        ACTUATOR,
        "actdim actearly actlimited actrange biasprm biastype body ctrllimited dynprm dyntype ffrange \
         forcelimited forcerange gainprm gaintype inheritrange input refsite site velrange",
    ),
    (Section::Actuator, "motor", ACTUATOR, "ctrllimited forcelimited forcerange refsite site"),
    (
        Section::Actuator,
        "position",
        ACTUATOR,
        "ctrllimited dampratio forcelimited forcerange inheritrange kp kv refsite site timeconst",
    ),
    (Section::Actuator, "velocity", ACTUATOR, "ctrllimited forcelimited forcerange kv refsite site"),
    (
        Section::Actuator,
        "intvelocity",
        ACTUATOR,
        "actlimited actrange ctrllimited dampratio forcelimited forcerange inheritrange kp kv refsite site",
    ),
    (
        Section::Actuator,
        "orientation",
        "",
        "class ctrlrange dampratio delay forcelimited forcerange group input interp joint kp kv name nsample \
         refsite site user",
    ),
    (
        Section::Actuator,
        "pid",
        ACTUATOR,
        "ctrllimited dampratio ffrange forcelimited forcerange imax inheritrange input ki kp kv posrange \
         refsite site slewmax velrange",
    ),
    (Section::Actuator, "damper", ACTUATOR, "forcelimited forcerange kv refsite site"),
    (
        Section::Actuator,
        "cylinder",
        ACTUATOR,
        "area bias ctrllimited diameter forcelimited forcerange refsite site timeconst",
    ),
    (
        Section::Actuator,
        "muscle",
        ACTUATOR,
        "ctrllimited force forcelimited forcerange fpmax fvmax lmax lmin range scale tausmooth timeconst vmax",
    ),
    (
        Section::Actuator,
        "adhesion",
        "",
        "body class ctrlrange delay forcelimited forcerange gain group interp name nsample user",
    ),
    (
        Section::Actuator,
        "dcmotor",
        ACTUATOR,
        "cogging controller ctrllimited inductance input lugre motorconst nominal refsite resistance \
         saturation site thermal",
    ),
    (
        Section::Actuator,
        "plugin",
        ACTUATOR,
        "actdim actearly actlimited actrange ctrllimited dynprm dyntype forcelimited forcerange instance \
         plugin site",
    ),
    (Section::Default, "mesh", "", "inertia maxhullvert scale"),
    (
        Section::Default,
        "texture",
        "",
        "builtin colorspace embed gridlayout gridsize height hflip mark markrgb nchannel random rgb1 rgb2 type \
         vflip width",
    ),
    (
        Section::Default,
        "material",
        "",
        "emission metallic reflectance rgba roughness shininess specular texrepeat texture texuniform",
    ),
    (Section::Default, "pair", "", "adhesion condim friction gap margin solimp solref solreffriction"),
    (Section::Default, "equality", "", "active solimp solref"),
    (
        Section::Default,
        "tendon",
        "",
        "actuatorfrclimited actuatorfrcrange armature damping frictionloss group limited margin material range \
         rgba solimpfriction solimplimit solreffriction solreflimit springlength springyield stiffness user \
         width",
    ),
];
