"""Thirty systems outside of the catalogue, with the equations that a book prints for them.

Letters are those of the declaration: ``xdot`` and ``xddot`` are rates, what a book names stands
below its equations, and is counted with them.  Books differ in letters and signs; the equations are
theirs, the notation is one for all.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import voronec as vo
from voronec.algebra.text import formula


class Textbook(NamedTuple):
    """A system as text, and the equations of a book for it, names below them last."""

    name: str
    source: str
    base: str
    lagrangian: str
    parameters: str
    equations: str
    fibre: str = ""
    constraints: str = ""
    frame: str = ""
    forces: str = ""
    inputs: str = ""

    @property
    def system(self) -> vo.System:
        """The system that is declared."""
        given: dict[str, Any] = {}
        if self.frame:
            given["frame"] = vo.Frame.quasi({read(v): read(e) for v, e in pairs(self.frame, ":")})
        return vo.System(
            name=self.name.replace(" ", "-"),
            fibration=vo.Fibration(symbols(self.base), symbols(self.fibre)),
            lagrangian=read(self.lagrangian),
            constraints=tuple(map(read, parts(self.constraints))),
            forces={read(q): read(e) for q, e in pairs(self.forces, ":")},
            parameters=symbols(self.parameters),
            inputs=symbols(self.inputs),
            **given,
        )

    @property
    def length(self) -> int:
        """The characters of the book, blanks aside."""
        return sum(len(line.replace(" ", "")) for line in parts(self.equations))


def read(text: str) -> Any:
    """A formula; numbers, functions and the letters of the declaration."""
    return formula(text, "a formula of a book", {})


def parts(text: str) -> list[str]:
    """What stands between semicolons."""
    return [part.strip() for part in text.split(";") if part.strip()]


def pairs(text: str, sign: str) -> list[tuple[str, str]]:
    """Two sides of each part."""
    return [tuple(part.split(sign)) for part in parts(text)]  # type: ignore[misc]


def symbols(text: str) -> tuple[Any, ...]:
    """The symbols of a text."""
    return tuple(map(read, text.split()))


EULER = (
    "omega1: phidot*sin(theta)*sin(psi) + thetadot*cos(psi); "
    "omega2: phidot*sin(theta)*cos(psi) - thetadot*sin(psi); omega3: phidot*cos(theta) + psidot"
)
SPIN = """
    phidot*sin(theta) = omega1*sin(psi) + omega2*cos(psi);
    thetadot = omega1*cos(psi) - omega2*sin(psi);
    psidot = omega3 - phidot*cos(theta);
"""
BODY = (
    "(I1*(phidot*sin(theta)*sin(psi) + thetadot*cos(psi))^2 + "
    "I2*(phidot*sin(theta)*cos(psi) - thetadot*sin(psi))^2 + I3*(phidot*cos(theta) + psidot)^2)/2"
)
ALONG = "v: xdot*cos(phi) + ydot*sin(phi); w: phidot"
BLADE = "xdot*sin(phi) - ydot*cos(phi)"
TWO_LINKS = (
    "(I1 + m1*r1^2)*theta1dot^2/2 + I2*(theta1dot + theta2dot)^2/2 + "
    "m2*(l1^2*theta1dot^2 + r2^2*(theta1dot + theta2dot)^2 + "
    "2*l1*r2*theta1dot*(theta1dot + theta2dot)*cos(theta2))/2"
)

TEXTBOOK = (
    Textbook(
        "knife edge on an inclined plane", "Neimark and Fufaev 1972; Bloch 2003, section 1.6",
        "x phi", "m*(xdot^2 + ydot^2)/2 + J*phidot^2/2 + m*g*x*sin(alpha)", "m J g alpha",
        "xdot = v*cos(phi); ydot = v*sin(phi); phidot = w; vdot = g*sin(alpha)*cos(phi); wdot = 0",
        fibre="y", constraints=BLADE, frame=ALONG,
    ),
    Textbook(
        "sleigh on an inclined plane", "Borisov and Mamaev 2009, on the Chaplygin sleigh",
        "x phi",
        "m*(xdot^2 + ydot^2)/2 + (J + m*a^2)*phidot^2/2"
        " + m*a*phidot*(ydot*cos(phi) - xdot*sin(phi)) + m*g*sin(alpha)*(x + a*cos(phi))",
        "m J a g alpha",
        """xdot = v*cos(phi); ydot = v*sin(phi); phidot = w;
        vdot = a*w^2 + g*sin(alpha)*cos(phi);
        (J + m*a^2)*wdot = -m*a*v*w - m*a*g*sin(alpha)*sin(phi)""",
        fibre="y", constraints=BLADE, frame=ALONG,
    ),
    Textbook(
        "dumbbell with a knife edge", "Greenwood 2003, example of section 4.2",
        "x phi",
        "(m1 + m2)*(xdot^2 + ydot^2)/2 + m2*l^2*phidot^2/2 "
        "+ m2*l*phidot*(ydot*cos(phi) - xdot*sin(phi))", "m1 m2 l",
        "xdot = v*cos(phi); ydot = v*sin(phi); phidot = w; "
        "(m1 + m2)*vdot = m2*l*w^2; l*wdot = -v*w",
        fibre="y", constraints=BLADE, frame=ALONG,
    ),
    Textbook(
        "robot with two driven wheels",
        "Fierro and Lewis 1995; Siciliano et al. 2009, section 11.4",
        "x phi",
        "m*(xdot^2 + ydot^2)/2 + (J + m*d^2)*phidot^2/2"
        " + m*d*phidot*(ydot*cos(phi) - xdot*sin(phi))",
        "m J d r b",
        """xdot = v*cos(phi); ydot = v*sin(phi); phidot = w;
        m*vdot - m*d*w^2 = (tau1 + tau2)/r; (J + m*d^2)*wdot + m*d*v*w = b*(tau1 - tau2)/r""",
        fibre="y", constraints=BLADE, frame=ALONG, inputs="tau1 tau2",
        forces="x: (tau1 + tau2)*cos(phi)/r; y: (tau1 + tau2)*sin(phi)/r; phi: b*(tau1 - tau2)/r",
    ),
    Textbook(
        "upright disc on an inclined plane", "Bloch 2003, section 1.4; Neimark and Fufaev 1972",
        "phi psi",
        "m*(xdot^2 + ydot^2)/2 + I*psidot^2/2 + J*phidot^2/2 + m*g*x*sin(alpha)", "m I J R g alpha",
        """xdot = R*psidot*cos(phi); ydot = R*psidot*sin(phi);
        (I + m*R^2)*psiddot = m*g*R*sin(alpha)*cos(phi); J*phiddot = 0""",
        fibre="x y", constraints="xdot - R*psidot*cos(phi); ydot - R*psidot*sin(phi)",
    ),
    Textbook(
        "driven unicycle", "Bullo and Lewis 2004, section 1.2",
        "phi psi", "m*(xdot^2 + ydot^2)/2 + I*psidot^2/2 + J*phidot^2/2", "m I J R",
        """xdot = R*psidot*cos(phi); ydot = R*psidot*sin(phi);
        (I + m*R^2)*psiddot = tau1; J*phiddot = tau2""",
        fibre="x y", constraints="xdot - R*psidot*cos(phi); ydot - R*psidot*sin(phi)",
        forces="psi: tau1; phi: tau2", inputs="tau1 tau2",
    ),
    Textbook(
        "rolling hoop", "Neimark and Fufaev 1972; Cushman, Hermans and Kemppainen 1996",
        "phi theta psi",
        "m*((xdot - R*thetadot*sin(phi)*cos(theta) - R*phidot*cos(phi)*sin(theta))^2"
        " + (ydot + R*thetadot*cos(phi)*cos(theta) - R*phidot*sin(phi)*sin(theta))^2"
        " + R^2*thetadot^2*sin(theta)^2)/2"
        " + m*R^2*(thetadot^2 + phidot^2*cos(theta)^2)/4"
        " + m*R^2*(psidot - phidot*sin(theta))^2/2 - m*g*R*cos(theta)", "m R g",
        """phidot = q/cos(theta); thetadot = p; psidot = s + q*tan(theta);
        xdot = R*psidot*cos(phi); ydot = R*psidot*sin(phi);
        3*R*pdot = 2*g*sin(theta) - R*q^2*tan(theta) - 4*R*q*s;
        qdot = p*q*tan(theta) + 2*p*s; 2*sdot = p*q""",
        fibre="x y", constraints="xdot - R*psidot*cos(phi); ydot - R*psidot*sin(phi)",
        frame="p: thetadot; q: phidot*cos(theta); s: psidot - phidot*sin(theta)",
    ),
    Textbook(
        "car", "De Luca and Oriolo 1995, section 6; LaValle 2006, section 13.2",
        "x phi",
        "m*(xdot^2 + ydot^2)/2 + J*thetadot^2/2 + K*phidot^2/2", "m J K l",
        """xdot = v*cos(theta); ydot = v*sin(theta); thetadot = v*tan(phi)/l; phidot = w;
        (m*l^2*cos(phi)^2 + J*sin(phi)^2)*vdot + J*v*w*tan(phi) = l^2*F*cos(phi)^2; K*wdot = tau""",
        fibre="y theta", inputs="F tau", frame="v: xdot*cos(theta) + ydot*sin(theta); w: phidot",
        constraints="xdot*sin(theta) - ydot*cos(theta); "
        "l*thetadot*cos(phi) - (xdot*cos(theta) + ydot*sin(theta))*sin(phi)",
        forces="x: F*cos(theta); y: F*sin(theta); phi: tau",
    ),
    Textbook(
        "trailer with a hitch off the axle", "Altafini 2001; Bolzern et al. 1998",
        "x phi", "m*(xdot^2 + ydot^2)/2 + J*phidot^2/2", "m J a l",
        """xdot = v*cos(phi); ydot = v*sin(phi); phidot = w;
        psidot = (v*sin(phi - psi) - a*w*cos(phi - psi))/l; m*vdot = F; J*wdot = tau""",
        fibre="y psi", frame=ALONG, inputs="F tau",
        constraints=BLADE + "; l*psidot - (xdot*cos(phi) + ydot*sin(phi))*sin(phi - psi)"
        " + a*phidot*cos(phi - psi)", forces="x: F*cos(phi); y: F*sin(phi); phi: tau",
    ),
    Textbook(
        "car with a trailer", "Laumond 1998; dynamics as in Bloch 2003, section 5.2",
        "x phi",
        "m*(xdot^2 + ydot^2)/2 + J*phidot^2/2 + J1*psidot^2/2 + m1*((xdot + l*psidot*sin(psi))^2"
        " + (ydot - l*psidot*cos(psi))^2)/2", "m J m1 J1 l",
        """xdot = v*cos(phi); ydot = v*sin(phi); phidot = w; psidot = v*sin(delta)/l;
        (m + m1*cos(delta)^2 + J1*sin(delta)^2/l^2)*vdot
        + (J1/l^2 - m1)*(w - psidot)*v*sin(delta)*cos(delta) = 0; J*wdot = 0; delta = phi - psi""",
        fibre="y psi", frame=ALONG,
        constraints=BLADE + "; l*psidot - (xdot*cos(phi) + ydot*sin(phi))*sin(phi - psi)",
    ),
    Textbook(
        "ellipse rolling on a line", "Lurie 1961, rolling by the support function",
        "phi",
        "m*(xdot^2 + ((a^2 - b^2)*sin(phi)*cos(phi)/sqrt(a^2*sin(phi)^2 + b^2*cos(phi)^2))^2"
        "*phidot^2)/2 + J*phidot^2/2 - m*g*sqrt(a^2*sin(phi)^2 + b^2*cos(phi)^2)", "m J a b g",
        """xdot = p*phidot; (J + m*(p^2 + q^2))*phiddot + m*q*(a^2*b^2*phidot^2/p^3 + g) = 0;
        p = sqrt(a^2*sin(phi)^2 + b^2*cos(phi)^2); q = (a^2 - b^2)*sin(phi)*cos(phi)/p""",
        fibre="x", constraints="xdot - sqrt(a^2*sin(phi)^2 + b^2*cos(phi)^2)*phidot",
    ),
    Textbook(
        "unbalanced disc rolling on a line", "Ginsberg 2008, chapter 7",
        "theta",
        "m*(xdot^2 - 2*a*xdot*thetadot*cos(theta) + a^2*thetadot^2)/2 + J*thetadot^2/2"
        " + m*g*a*cos(theta)", "m J R a g",
        """xdot = R*thetadot; (J + m*(R^2 + a^2 - 2*R*a*cos(theta)))*thetaddot
        + m*R*a*thetadot^2*sin(theta) + m*g*a*sin(theta) = 0""",
        fibre="x", constraints="xdot - R*thetadot",
    ),
    Textbook(
        "cylinder in a cylinder", "Landau and Lifshitz 1976, section 32; Greenwood 2003",
        "theta",
        "m*(R - r)^2*thetadot^2/2 + m*r^2*psidot^2/4 + m*g*(R - r)*cos(theta)", "m R r g",
        "psidot = -(R - r)*thetadot/r; 3*(R - r)*thetaddot + 2*g*sin(theta) = 0",
        fibre="psi", constraints="r*psidot + (R - r)*thetadot",
    ),
    Textbook(
        "particle of the Heisenberg group", "Bloch 2003, section 1.8; Brockett 1981",
        "x y", "m*(xdot^2 + ydot^2 + zdot^2)/2", "m",
        "zdot = x*ydot - y*xdot; xddot = 0; yddot = 0",
        fibre="z", constraints="zdot - x*ydot + y*xdot",
    ),
    Textbook(
        "particle on a turning skate", "Rosenberg 1977, chapter 14; Cortes 2002",
        "x y", "m*(xdot^2 + ydot^2 + zdot^2)/2 - m*g*z", "m g k",
        """zdot = k*x*ydot; xddot = 0;
        (1 + k^2*x^2)*yddot + k^2*x*xdot*ydot + g*k*x = 0""",
        fibre="z", constraints="zdot - k*x*ydot",
    ),
    Textbook(
        "free rigid body", "Landau and Lifshitz 1976, sections 35 and 36",
        "phi theta psi", BODY, "I1 I2 I3",
        SPIN + """I1*omega1dot = (I2 - I3)*omega2*omega3; I2*omega2dot = (I3 - I1)*omega3*omega1;
        I3*omega3dot = (I1 - I2)*omega1*omega2""", frame=EULER,
    ),
    Textbook(
        "gyrostat", "Wittenburg 2008, section 4.6",
        "phi theta psi", BODY + " + h*(phidot*cos(theta) + psidot)", "I1 I2 I3 h",
        SPIN + """I1*omega1dot = (I2 - I3)*omega2*omega3 - h*omega2;
        I2*omega2dot = (I3 - I1)*omega3*omega1 + h*omega1;
        I3*omega3dot = (I1 - I2)*omega1*omega2""", frame=EULER,
    ),
    Textbook(
        "heavy symmetric top", "Greenwood 2003, section 3.4; Goldstein 1980, section 5.7",
        "phi theta psi",
        "A*(thetadot^2 + phidot^2*sin(theta)^2)/2 + C*(psidot + phidot*cos(theta))^2/2"
        " - m*g*l*cos(theta)", "A C m g l",
        """phidot = p; thetadot = q; psidot = n - p*cos(theta); ndot = 0;
        A*qdot = A*p^2*sin(theta)*cos(theta) - C*n*p*sin(theta) + m*g*l*sin(theta);
        A*pdot*sin(theta) = C*n*q - 2*A*p*q*cos(theta)""",
        frame="p: phidot; q: thetadot; n: psidot + phidot*cos(theta)",
    ),
    Textbook(
        "cart with a pendulum", "Bloch 2003, section 1.7; Astrom and Murray 2008, example 2.1",
        "x theta",
        "(M + m)*xdot^2/2 + m*l*xdot*thetadot*cos(theta) + m*l^2*thetadot^2/2 - m*g*l*cos(theta)",
        "M m l g",
        """(M + m)*xddot + m*l*thetaddot*cos(theta) - m*l*thetadot^2*sin(theta) = F;
        xddot*cos(theta) + l*thetaddot - g*sin(theta) = 0""", forces="x: F", inputs="F",
    ),
    Textbook(
        "double pendulum", "Landau and Lifshitz 1976, section 5; Greenwood 2003",
        "theta1 theta2",
        "(m1 + m2)*l1^2*theta1dot^2/2 + m2*l2^2*theta2dot^2/2"
        " + m2*l1*l2*theta1dot*theta2dot*cos(theta1 - theta2)"
        " + (m1 + m2)*g*l1*cos(theta1) + m2*g*l2*cos(theta2)", "m1 m2 l1 l2 g",
        """(m1 + m2)*l1*theta1ddot + m2*l2*theta2ddot*cos(theta1 - theta2)
        + m2*l2*theta2dot^2*sin(theta1 - theta2) + (m1 + m2)*g*sin(theta1) = 0;
        l2*theta2ddot + l1*theta1ddot*cos(theta1 - theta2)
        - l1*theta1dot^2*sin(theta1 - theta2) + g*sin(theta2) = 0""",
    ),
    Textbook(
        "robot with two links", "Murray, Li and Sastry 1994, section 4.2.3",
        "theta1 theta2", TWO_LINKS, "m1 m2 I1 I2 l1 r1 r2",
        """(alpha + 2*beta*cos(theta2))*theta1ddot + (delta + beta*cos(theta2))*theta2ddot
        - beta*sin(theta2)*theta2dot*theta1dot - beta*sin(theta2)*(theta1dot + theta2dot)*theta2dot
        = tau1; (delta + beta*cos(theta2))*theta1ddot + delta*theta2ddot
        + beta*sin(theta2)*theta1dot^2 = tau2;
        alpha = I1 + I2 + m1*r1^2 + m2*(l1^2 + r2^2); beta = m2*l1*r2; delta = I2 + m2*r2^2""",
        forces="theta1: tau1; theta2: tau2", inputs="tau1 tau2",
    ),
    Textbook(
        "acrobot", "Spong 1995; Bullo and Lewis 2004",
        "theta1 theta2",
        TWO_LINKS + " - (m1*r1 + m2*l1)*g*sin(theta1) - m2*r2*g*sin(theta1 + theta2)",
        "m1 m2 I1 I2 l1 r1 r2 g",
        """d11*theta1ddot + d12*theta2ddot + h1 + p1 = 0; d12*theta1ddot + d22*theta2ddot + h2 + p2
        = tau; d11 = m1*r1^2 + m2*(l1^2 + r2^2 + 2*l1*r2*cos(theta2)) + I1 + I2;
        d22 = m2*r2^2 + I2; d12 = m2*(r2^2 + l1*r2*cos(theta2)) + I2;
        h1 = -m2*l1*r2*sin(theta2)*theta2dot^2 - 2*m2*l1*r2*sin(theta2)*theta2dot*theta1dot;
        h2 = m2*l1*r2*sin(theta2)*theta1dot^2;
        p1 = (m1*r1 + m2*l1)*g*cos(theta1) + m2*r2*g*cos(theta1 + theta2);
        p2 = m2*r2*g*cos(theta1 + theta2)""",
        forces="theta2: tau", inputs="tau",
    ),
    Textbook(
        "robot with a turning and a sliding joint", "Craig 2005, section 6.7; LaValle 2006",
        "theta r",
        "(I1 + I2 + m1*l1^2 + m2*r^2)*thetadot^2/2 + m2*rdot^2/2 - g*(m1*l1 + m2*r)*sin(theta)",
        "m1 m2 I1 I2 l1 g",
        """(m1*l1^2 + I1 + I2 + m2*r^2)*thetaddot + 2*m2*r*thetadot*rdot
        + (m1*l1 + m2*r)*g*cos(theta) = tau; m2*rddot - m2*r*thetadot^2 + m2*g*sin(theta) = F""",
        forces="theta: tau; r: F", inputs="tau F",
    ),
    Textbook(
        "pendulum on a turning arm", "Cazzolato and Prime 2011, on the Furuta pendulum",
        "phi theta",
        "(J + m*L^2 + m*l^2*sin(theta)^2)*phidot^2/2 + m*L*l*phidot*thetadot*cos(theta)"
        " + m*l^2*thetadot^2/2 - m*g*l*cos(theta)", "J m L l g",
        """(J + m*L^2 + m*l^2*sin(theta)^2)*phiddot + m*L*l*cos(theta)*thetaddot
        - m*L*l*sin(theta)*thetadot^2 + m*l^2*phidot*thetadot*sin(2*theta) = tau;
        m*L*l*cos(theta)*phiddot + m*l^2*thetaddot - m*l^2*phidot^2*sin(2*theta)/2
        - m*g*l*sin(theta) = 0""", forces="phi: tau", inputs="tau",
    ),
    Textbook(
        "ball on a beam", "Hauser, Sastry and Kokotovic 1992",
        "r theta",
        "(I/R^2 + M)*rdot^2/2 + (M*r^2 + J + I)*thetadot^2/2 - M*g*r*sin(theta)", "M J I R g",
        """(I/R^2 + M)*rddot + M*g*sin(theta) - M*r*thetadot^2 = 0;
        (M*r^2 + J + I)*thetaddot + 2*M*r*rdot*thetadot + M*g*r*cos(theta) = tau""",
        forces="theta: tau", inputs="tau",
    ),
    Textbook(
        "spherical pendulum", "Landau and Lifshitz 1976, section 14; Greenwood 2003",
        "theta phi",
        "m*l^2*(thetadot^2 + phidot^2*sin(theta)^2)/2 + m*g*l*cos(theta)", "m l g",
        """l*thetaddot - l*phidot^2*sin(theta)*cos(theta) + g*sin(theta) = 0;
        phiddot*sin(theta) + 2*phidot*thetadot*cos(theta) = 0""",
    ),
    Textbook(
        "pendulum on a spring", "Nayfeh and Mook 1979; Greenwood 2003",
        "r theta",
        "m*(rdot^2 + r^2*thetadot^2)/2 - k*(r - l)^2/2 + m*g*r*cos(theta)", "m k l g",
        """m*rddot - m*r*thetadot^2 + k*(r - l) - m*g*cos(theta) = 0;
        r*thetaddot + 2*rdot*thetadot + g*sin(theta) = 0""",
    ),
    Textbook(
        "bead on a turning hoop", "Marsden and Ratiu 1999, section 2.8; Goldstein 1980",
        "theta",
        "m*R^2*(thetadot^2 + Omega^2*sin(theta)^2)/2 + m*g*R*cos(theta)", "m R Omega g",
        "R*thetaddot = R*Omega^2*sin(theta)*cos(theta) - g*sin(theta)",
    ),
    Textbook(
        "swinging Atwood machine", "Tufillaro, Abbott and Griffiths 1984",
        "r theta",
        "(M + m)*rdot^2/2 + m*r^2*thetadot^2/2 - M*g*r + m*g*r*cos(theta)", "M m g",
        """(M + m)*rddot = m*r*thetadot^2 - M*g + m*g*cos(theta);
        r*thetaddot + 2*rdot*thetadot + g*sin(theta) = 0""",
    ),
    Textbook(
        "pendulum on two wheels", "Grasser et al. 2002; Kane and Levinson 1985 for the method",
        "x theta",
        "(M + m)*xdot^2/2 + I*psidot^2/2 + m*l*xdot*thetadot*cos(theta) + (J + m*l^2)*thetadot^2/2"
        " - m*g*l*cos(theta)", "M m I J l r g",
        """psidot = xdot/r;
        (M + m + I/r^2)*xddot + m*l*thetaddot*cos(theta) - m*l*thetadot^2*sin(theta) = tau/r;
        m*l*xddot*cos(theta) + (J + m*l^2)*thetaddot - m*g*l*sin(theta) = -tau""",
        fibre="psi", constraints="r*psidot - xdot", forces="psi: tau; theta: -tau", inputs="tau",
    ),
)  # fmt: skip
